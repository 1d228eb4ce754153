use iorect::render::*;
use iorect::tracking::Mode;
use std::sync::{Arc, atomic::AtomicBool};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let d = iorect::scene::load::open(&a[1]).unwrap();
    let t = std::time::Instant::now();
    let p = prepare(Arc::new(d), None).unwrap();
    println!("prepare {:?} total {:?}", p.seconds, t.elapsed());
    for patch in &p.table.patches {
        println!(
            "{} outside {} conf {} rays {}",
            p.world.object(patch.refractor).name,
            p.world.medium(patch.outside).name,
            patch.confidence,
            patch.rays
        );
    }
    let mode: Mode = a[2].parse().unwrap();
    let spp: u32 = a[3].parse().unwrap();
    let size: u32 = a[4].parse().unwrap();
    let cam = iorect::scene::camera::Camera::new(&p.description.camera).unwrap();
    let mut f = Film::new(size, size);
    let t = std::time::Instant::now();
    accumulate(
        &p,
        &cam,
        &RenderSettings { mode, seed: a.get(6).map_or(0, |s| s.parse().unwrap()), max_depth: None, leave_out: true },
        &mut f,
        spp,
        &AtomicBool::new(false),
    );
    let s = t.elapsed().as_secs_f64();
    println!("{s:.2} s, {:.3} Msps, {:?}", size as f64 * size as f64 * spp as f64 / s / 1e6, f.events);
    let rgb = f.to_rgb();
    if a.len() > 5 && a[5] != "-" {
        let r = image::open(&a[5]).unwrap().to_rgb32f();
        let x: Vec<f64> = rgb.iter().flatten().map(|v| *v as f64).collect();
        let y: Vec<f64> = r.as_raw().iter().map(|v| *v as f64).collect();
        let rel = |x: &[f64], y: &[f64]| {
            x.iter().zip(y).map(|(x, r)| (x - r) * (x - r) / (r * r + 0.01)).sum::<f64>() / x.len() as f64
        };
        let n = size as usize;
        let b = 16;
        let m = n / b;
        let block = |v: &[f64]| {
            let mut o = vec![0.0; m * m * 3];
            for i in 0..n {
                for j in 0..n {
                    for c in 0..3 {
                        o[((i / b) * m + j / b) * 3 + c] += v[(i * n + j) * 3 + c] / (b * b) as f64;
                    }
                }
            }
            o
        };
        println!(
            "relmse {:e} block {:e} mean {} {}",
            rel(&x, &y),
            rel(&block(&x), &block(&y)),
            x.iter().sum::<f64>() / x.len() as f64,
            y.iter().sum::<f64>() / y.len() as f64
        );
    }
    let img = image::RgbImage::from_fn(size, size, |x, y| {
        image::Rgb(Display::default().encode(rgb[(y * size + x) as usize]))
    });
    img.save("/tmp/probe.png").unwrap();
}
