//! Makes the assets that are computed rather than written: `cargo run --example make_assets`.
//!
//! - `assets/models/brilliant.obj`: a round brilliant cut diamond with the proportions of Tolkowsky (1919).
//! - `assets/models/ice-cube.obj`: a cube whose edges and corners have melted round.
//! - `assets/scenes/luneburg.toml`: a Luneburg lens as concentric shells.
//! - `assets/environments/evening.exr`: `sunset.exr` with a dimmed sun, in warmer colours.

use std::error::Error;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

use exr::prelude::{
    Blocks, Compression, Encoding, Image, LayerAttributes, LineOrder, SpecificChannels, Vec2, WritableImage, f16,
};

fn main() -> Result<(), Box<dyn Error>> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    std::fs::write(assets.join("models/brilliant.obj"), brilliant())?;
    std::fs::write(assets.join("models/ice-cube.obj"), ice_cube())?;
    std::fs::write(assets.join("scenes/luneburg.toml"), luneburg())?;
    let environments = assets.join("environments");
    let mut picture = image::open(environments.join("sunset.exr"))?.to_rgb32f();
    picture.pixels_mut().for_each(|pixel| pixel.0 = evening(pixel.0));
    std::fs::write(environments.join("evening.exr"), encode(&picture)?)?;
    Ok(())
}

/// A pixel of the evening, from one of the sunset. It is dimmed to no more than the sky beside the sun, which changes the sun and little else:
/// through glass a sun is found by few paths, and pictures stay noisy for long. Then the balance of white is moved, so that the sky is near white.
pub fn evening(sunset: [f32; 3]) -> [f32; 3] {
    const MOST: f32 = 6.0;
    const BALANCE: [f32; 3] = [1.4, 1.1, 0.78];
    let most = sunset.into_iter().fold(0.0, f32::max);
    let dimmed = if most > MOST { MOST / most } else { 1.0 };
    let [r, g, b] = sunset;
    [r * BALANCE[0], g * BALANCE[1], b * BALANCE[2]].map(|value| value * dimmed)
}

/// An OpenEXR picture in half precision.
fn encode(picture: &image::Rgb32FImage) -> exr::error::Result<Vec<u8>> {
    let (width, height) = picture.dimensions();
    let pixel = |at: Vec2<usize>| {
        let [r, g, b] = picture.get_pixel(at.x() as u32, at.y() as u32).0.map(f16::from_f32);
        (r, g, b)
    };
    let encoding =
        Encoding { compression: Compression::PIZ, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = (width as usize, height as usize);
    let layer = exr::prelude::Layer::new(size, LayerAttributes::default(), encoding, SpecificChannels::rgb(pixel));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// A round brilliant of girdle radius 1, table up: 33 facets above the girdle, 24 below, and the girdle's 16. Its origin lies in the
/// plane of the girdle, on the axis.
pub fn brilliant() -> String {
    // Tolkowsky's proportions; the length of stars and lower halves as cutters choose them today.
    let table_radius = 0.53;
    let crown_tangent = 34.5_f64.to_radians().tan();
    let pavilion_tangent = 40.75_f64.to_radians().tan();
    let half_girdle = 0.02;
    let star_radius = 0.74;
    let lower_half_radius = 0.24;

    // Heights on the planes of the mains, which pass through the girdle's edge. Half a main's width is 22.5°.
    let half_width = (PI / 8.0).cos();
    let table_y = half_girdle + (1.0 - table_radius) * crown_tangent;
    let star_y = half_girdle + (1.0 - star_radius * half_width) * crown_tangent;
    let lower_y = -half_girdle - (1.0 - lower_half_radius * half_width) * pavilion_tangent;
    let culet_y = -half_girdle - pavilion_tangent;

    // Rings of eight: on the axes of the mains (even sixteenths) or between them (odd).
    let rings = [
        (table_radius, table_y, 0), // 0: table
        (star_radius, star_y, 1),   // 1: where star, mains and upper halves meet
        (1.0, half_girdle, 0),      // 2, 3: upper edge of the girdle
        (1.0, half_girdle, 1),
        (1.0, -half_girdle, 0), // 4, 5: its lower edge
        (1.0, -half_girdle, 1),
        (lower_half_radius, lower_y, 1), // 6: where mains and lower halves meet
    ];
    let mut text = String::from(
        "# A round brilliant cut diamond, girdle radius 1. Made by `cargo run --example make_assets`.\no brilliant\n",
    );
    for (radius, y, offset) in rings {
        for k in 0..8 {
            let angle = PI / 8.0 * f64::from(2 * k + offset);
            // Adding 0 turns −0 into 0.
            let [x, z] = [radius * angle.cos(), radius * angle.sin()].map(|v| (v * 1e7).round() / 1e7 + 0.0);
            _ = writeln!(text, "v {x:.7} {y:.7} {z:.7}");
        }
    }
    _ = writeln!(text, "v 0 {culet_y:.7} 0");
    let vertex = |ring: usize, k: usize| 8 * ring + k % 8 + 1;
    let culet = 8 * rings.len() + 1;
    // Angles run from +x towards +z, clockwise seen from above.
    let mut face = |corners: &[usize]| {
        let corners: Vec<String> = corners.iter().rev().map(ToString::to_string).collect();
        _ = writeln!(text, "f {}", corners.join(" "));
    };
    face(&(0..8).map(|k| vertex(0, k)).collect::<Vec<_>>());
    for k in 0..8 {
        let next = k + 1;
        let before = k + 7;
        face(&[vertex(0, next), vertex(0, k), vertex(1, k)]); // star
        face(&[vertex(0, k), vertex(1, before), vertex(2, k), vertex(1, k)]); // main
        face(&[vertex(1, k), vertex(2, k), vertex(3, k)]); // upper halves
        face(&[vertex(1, k), vertex(3, k), vertex(2, next)]);
        face(&[vertex(2, k), vertex(4, k), vertex(5, k), vertex(3, k)]); // girdle
        face(&[vertex(3, k), vertex(5, k), vertex(4, next), vertex(2, next)]);
        face(&[vertex(5, k), vertex(4, k), vertex(6, k)]); // lower halves
        face(&[vertex(4, next), vertex(5, k), vertex(6, k)]);
        face(&[vertex(4, k), vertex(6, before), culet, vertex(6, k)]); // pavilion main
    }
    text
}

/// The superellipsoid |x|⁶ + |y|⁶ + |z|⁶ = 1, a cube of half edge 1 with round edges and corners, with its exact normals. Its vertices lie on
/// those of a cube that is divided by equal angles.
pub fn ice_cube() -> String {
    const EXPONENT: i32 = 6;
    const DIVISIONS: i32 = 20;
    let mut text = String::from(
        "# A cube of half edge 1 with round edges, |x|^6 + |y|^6 + |z|^6 = 1. Made by `cargo run --example make_assets`.\no ice-cube\n",
    );
    // Points of the divided cube, in steps from −DIVISIONS to DIVISIONS; those on edges belong to several sides.
    let mut vertices: Vec<[i32; 3]> = Vec::new();
    let mut faces = String::new();
    for axis in 0..3 {
        for side in [-DIVISIONS, DIVISIONS] {
            let mut vertex = |u: i32, v: i32| {
                let mut point = [0; 3];
                point[axis] = side;
                point[(axis + 1) % 3] = u;
                point[(axis + 2) % 3] = v;
                let known = vertices.iter().position(|known| *known == point);
                1 + known.unwrap_or_else(|| {
                    vertices.push(point);
                    vertices.len() - 1
                })
            };
            for u in (-DIVISIONS..DIVISIONS).step_by(2) {
                for v in (-DIVISIONS..DIVISIONS).step_by(2) {
                    let mut corners = [vertex(u, v), vertex(u + 2, v), vertex(u + 2, v + 2), vertex(u, v + 2)];
                    if side < 0 {
                        corners.reverse();
                    }
                    let [a, b, c, d] = corners;
                    _ = writeln!(faces, "f {a}//{a} {b}//{b} {c}//{c} {d}//{d}");
                }
            }
        }
    }
    let mut normals = String::new();
    for point in &vertices {
        let direction = point.map(|step| (PI / 4.0 * f64::from(step) / f64::from(DIVISIONS)).tan());
        let size = direction.iter().map(|d| d.powi(EXPONENT)).sum::<f64>().powf(1.0 / f64::from(EXPONENT));
        let position = direction.map(|d| d / size);
        let gradient = position.map(|p| p.powi(EXPONENT - 1));
        let length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        let rounded = |v: f64| (v * 1e6).round() / 1e6 + 0.0;
        let [x, y, z] = position.map(rounded);
        _ = writeln!(text, "v {x:.6} {y:.6} {z:.6}");
        let [x, y, z] = gradient.map(|g| rounded(g / length));
        _ = writeln!(normals, "vn {x:.6} {y:.6} {z:.6}");
    }
    text + &normals + &faces
}

/// Shells of the Luneburg lens n(r) = √(2 − r²), each with the index in the middle of its layer.
pub fn luneburg() -> String {
    const SHELLS: i32 = 30;
    let mut text = String::from(
        r#"# A Luneburg lens, n(r) = √(2 − r²), as 30 concentric shells: parallel light meets in a point of the far side. Stepwise graded
# media are nested dielectrics thirty deep. Made by `cargo run --example make_assets`.
name = "Luneburg lens"

[camera]
position = [0.0, 1.55, 5.6]
target = [0.0, 0.98, 0.0]
vertical_fov = 30.0

[environment]
image = "../environments/evening.exr"
rotation = -60.0
scale = 1.2

# A table of frosted glass with light below it.
[[light]]
name = "pane 1"
shape = { quad = { center = [-3.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.66, 0.46, 0.27]

[[light]]
name = "pane 2"
shape = { quad = { center = [-2.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.56, 0.38, 0.22]

[[light]]
name = "pane 3"
shape = { quad = { center = [-1.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.62, 0.43, 0.25]

[[light]]
name = "pane 4"
shape = { quad = { center = [0.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.66, 0.46, 0.27]

[[light]]
name = "pane 5"
shape = { quad = { center = [1.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.56, 0.38, 0.22]

[[light]]
name = "pane 6"
shape = { quad = { center = [2.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.62, 0.43, 0.25]

[[light]]
name = "pane 7"
shape = { quad = { center = [3.000, 0.0, 0.5], edge_u = [0.0, 0.0, 7.8], edge_v = [0.97, 0.0, 0.0] } }
radiance = [0.66, 0.46, 0.27]
"#,
    );
    for k in 0..SHELLS {
        let shells = f64::from(SHELLS);
        let radius = (shells - f64::from(k)) / shells;
        let middle = radius - 0.5 / shells;
        let n = (2.0 - middle * middle).sqrt();
        _ = write!(
            text,
            "\n[[medium]]\nname = \"layer {k}\"\nior = {n:.10}\n\n[[refractor]]\nname = \"shell {k}\"\nmedium = \"layer {k}\"\n\
             shape = {{ sphere = {{ center = [0.0, 1.02, 0.0], radius = {radius:.4} }} }}\n"
        );
    }
    text
}
