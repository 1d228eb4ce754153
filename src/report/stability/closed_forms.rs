//! Closed forms for whole scenes, in f64, from the indices and lengths alone.

use std::f64::consts::PI;

/// Reflectance of one interface between indices `n1` and `n2` at `cos_i`, unpolarised, from the textbook equations: for indices that are
/// well apart, where they keep their digits.
pub fn reflectance(n1: f64, n2: f64, cos_i: f64) -> f64 {
    let sin_squared = (n1 / n2).powi(2) * (1.0 - cos_i * cos_i);
    if sin_squared >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin_squared).sqrt();
    let rs = (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t);
    let rp = (n2 * cos_i - n1 * cos_t) / (n2 * cos_i + n1 * cos_t);
    0.5 * (rs * rs + rp * rp)
}

/// Transmittance of parallel interfaces between lossless media of `indices`, first to last, at `degrees` in the first; incoherent and
/// unpolarised, as a path tracer without polarisation sees it: T = 1/(1 + Σ Rᵢ/(1 − Rᵢ)).
pub fn stack_transmittance(indices: &[f64], degrees: f64) -> f64 {
    let invariant = indices[0] * degrees.to_radians().sin();
    let sum: f64 = (indices.windows(2))
        .map(|pair| {
            let cos_i = (1.0 - (invariant / pair[0]).powi(2)).sqrt();
            let r = reflectance(pair[0], pair[1], cos_i);
            r / (1.0 - r)
        })
        .sum();
    1.0 / (1.0 + sum)
}

/// Transmittance and reflectance of a slab of index `n` and optical depth `tau` along the ray, whose faces each reflect `r`: a geometric
/// series.
pub fn absorbing_slab(r: f64, tau: f64) -> (f64, f64) {
    let a = (-tau).exp();
    let transmittance = (1.0 - r).powi(2) * a / (1.0 - r * r * a * a);
    (transmittance, r + r * a * transmittance)
}

/// Where a ray goes that meets concentric spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Angle in degrees by which the ray is bent towards the centre, in (−180, 180].
    pub degrees: f64,
    /// Interfaces that it goes through, in and out.
    pub crossings: usize,
    pub is_reflected: bool,
    /// Whether it meets a sphere so near to the critical angle that rounding decides; the angle is the same either way.
    pub is_marginal: bool,
}

/// A ray at distance `b` from the centre of spheres (radius, index) in a world of index `n0`, outermost first, by Bouguer's invariant
/// n r sin i = h = n0 b: through each shell its azimuth turns by asin(h/(n r_in)) − asin(h/(n r_out)); it is reflected where the shell
/// below has n r ≤ h, and otherwise turns at the point nearest to the centre.
pub fn passage(n0: f64, shells: &[(f64, f64)], b: f64) -> Passage {
    let h = n0 * b;
    let outer = shells[0].0;
    // Swept from the first surface to the middle of the path.
    let mut swept = 0.0;
    let mut crossings = 0;
    let mut is_reflected = true;
    if h < shells[0].1 * outer {
        for (k, &(radius, n)) in shells.iter().enumerate() {
            crossings += 2;
            let entry = (h / (n * radius)).asin();
            // The ray turns in this shell if it misses the next, and at the next if that reflects totally.
            match shells.get(k + 1) {
                Some(&(inner, _)) if h < n * inner => {
                    swept += (h / (n * inner)).asin() - entry;
                    if h >= shells[k + 1].1 * inner {
                        break;
                    }
                }
                _ => {
                    swept += PI / 2.0 - entry;
                    is_reflected = false;
                    break;
                }
            }
        }
    }
    let is_marginal = shells.iter().enumerate().any(|(k, &(radius, n))| {
        let outside = if k == 0 { n0 } else { shells[k - 1].1 };
        h <= outside * radius && (h - n * radius).abs() <= 1e-12 * h
    });
    let radians = 2.0 * swept - (PI - 2.0 * (b / outer).asin());
    Passage { degrees: wrapped(radians.to_degrees()), crossings, is_reflected, is_marginal }
}

/// Into (−180, 180].
pub fn wrapped(degrees: f64) -> f64 {
    180.0 - (180.0 - degrees).rem_euclid(360.0)
}

/// Deviation of a ray through a ball of index `n` in vacuum at distance `b`, in radians, for an index as near to 1 as one likes:
/// 2 (asin b − asin(b/n)), without cancellation. `m` = n − 1.
pub fn ball_deflection(m: f64, b: f64) -> f64 {
    let n = 1.0 + m;
    let (cos_i, n_cos_t) = ((1.0 - b * b).sqrt(), (n * n - b * b).sqrt());
    // sin(i − t) = sin i cos t − cos i sin t = b (n cos t − cos i)/n, and n² cos²t − cos²i = n² − 1.
    2.0 * (b / n * (m * (2.0 + m)) / (n_cos_t + cos_i)).asin()
}

/// The same, from a world of index 1 + `m` through a bubble of vacuum: 2 (asin b − asin(n b)), for n b < 1.
pub fn bubble_deflection(m: f64, b: f64) -> f64 {
    let n = 1.0 + m;
    let (n_cos_i, cos_t) = (n * (1.0 - b * b).sqrt(), (1.0 - (n * b).powi(2)).sqrt());
    // sin(i − t) = b (cos t − n cos i), and cos²t − n² cos²i = 1 − n².
    -2.0 * (b * (m * (2.0 + m)) / (cos_t + n_cos_i)).asin()
}

/// Shells for a graded ball: r = (N − k)/N, n = n((N − k − ½)/N).
pub fn graded(count: usize, index: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let n = count as f64;
    (0..count).map(|k| ((n - k as f64) / n, index((n - k as f64 - 0.5) / n))).collect()
}

pub fn luneburg(r: f64) -> f64 {
    (2.0 - r * r).sqrt()
}

pub fn eaton(r: f64) -> f64 {
    (2.0 / r - 1.0).sqrt()
}

/// Mean over the disc of a ball of index `n` in vacuum of what follows from the reflectance. b² is uniform over the disc; the midpoint rule
/// in the cosine, db² = −2c dc, leaves out no grazing ray.
fn mean_over_disc(n: f64, of: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 20_000;
    let cosines = (0..STEPS).map(|k| (f64::from(k) + 0.5) / f64::from(STEPS));
    cosines.map(|c| 2.0 * c * of(reflectance(1.0, n, c))).sum::<f64>() / f64::from(STEPS)
}

/// Share of the light of a white room that needs more than `vertices` interface vertices in a ball of index `n` in vacuum, over its disc:
/// T R^(vertices − 1), because each internal reflection reflects R.
pub fn furnace_deficit(n: f64, vertices: u32) -> f64 {
    mean_over_disc(n, |r| (1.0 - r) * r.powi(vertices as i32 - 1))
}

/// Shares of the light that meets such a ball that are reflected outside (first) or leave after 0, 1, 2, … internal reflections: R, then
/// T² R^p.
pub fn shares_of_ball<const COUNT: usize>(n: f64) -> [f64; COUNT] {
    let share = |k: usize, r: f64| if k == 0 { r } else { (1.0 - r).powi(2) * r.powi(k as i32 - 1) };
    std::array::from_fn(|k| mean_over_disc(n, |r| share(k, r)))
}

/// Mean transmittance over the disc of a matched ball of radius R that absorbs σ: with s = σR, [1 − (1 + 2s) e^(−2s)]/(2s²).
pub fn absorbing_ball(s: f64) -> f64 {
    (1.0 - (1.0 + 2.0 * s) * (-2.0 * s).exp()) / (2.0 * s * s)
}

/// How far a slab of index `n` and thickness 1 moves a ray sideways that meets it at `degrees`.
pub fn lateral_shift(n: f64, degrees: f64) -> f64 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    sin * (1.0 - cos / (n * n - sin * sin).sqrt())
}

/// Mean over all directions of the radiance seen from a distance `a` from the centre of a unit ball of index `n` in a white room: n²
/// where a ray ever escapes, a n sin θ < 1, and nothing elsewhere.
pub fn radiance_in_ball(n: f64, a: f64) -> f64 {
    if a * n <= 1.0 { n * n } else { n * n * (1.0 - (1.0 - (1.0 / (a * n)).powi(2)).sqrt()) }
}

/// Angle between a ray and the way it leaves a prism of `apex` degrees and index `n_prism`, at minimum deviation in a world of `n_world`.
pub fn prism_deviation(n_world: f64, n_prism: f64, apex: f64) -> f64 {
    let half = (apex / 2.0).to_radians();
    2.0 * (n_prism / n_world * half.sin()).asin().to_degrees() - apex
}

/// Descartes' ray of the primary rainbow: the least deviation after one reflection inside a drop of index `n`, in degrees.
pub fn rainbow(n: f64) -> f64 {
    let b = ((4.0 - n * n) / 3.0).sqrt();
    180.0 + 2.0 * b.asin().to_degrees() - 4.0 * (b / n).asin().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} is not {expected}");
    }

    /// Values by 50-digit arithmetic.
    #[test]
    fn stacks_and_slabs() {
        for (degrees, r) in [(0.0, 0.0769230769), (45.0, 0.0956732085), (60.0, 0.163767537)] {
            close(1.0 - stack_transmittance(&[1.0, 1.5, 1.0], degrees), r, 1e-8);
        }
        for (degrees, t) in [(0.0, 0.917172595), (45.0, 0.898031936), (60.0, 0.829635708)] {
            close(stack_transmittance(&[1.0, 1.5, 1.333, 1.5, 1.0], degrees), t, 1e-8);
        }
        for (degrees, t) in [(0.0, 0.950888520), (45.0, 0.936681539), (60.0, 0.880217659)] {
            close(stack_transmittance(&[1.0, 1.31, 1.333, 1.5, 1.7, 1.5, 1.333, 1.31, 1.0], degrees), t, 1e-8);
        }
        let panes: Vec<f64> = (0..=200).map(|k| if k % 2 == 0 { 1.0 } else { 1.5 }).collect();
        close(stack_transmittance(&panes, 45.0), 0.0863595512, 1e-8);
        let (t, r) = absorbing_slab(0.04, 1.0);
        close(t, 0.339111123, 1e-8);
        close(r, 0.0449900804, 1e-8);
    }

    const HEIGHTS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

    /// Deflections by 50-digit arithmetic.
    #[test]
    fn passages() {
        let a = [(1.0, 1.5), (0.8, 1.333), (0.6, 1.0), (0.4, 2.417)];
        let f = [(1.0, 1.31), (0.9, 1.333), (0.8, 1.5), (0.7, 1.7), (0.6, 2.417)];
        let d = [(1.0, 1.5), (0.7, 1.333), (0.5, 1.5)];
        for (n0, shells, expected) in [
            (1.0, &a[..], [14.89026936, 53.20437591, -21.11344634, -35.32376167, 36.63552520]),
            (1.0, &f[..], [8.72537123, 27.01173198, 48.27519242, 76.89552179, 128.6267351]),
            (1.0, &d[..], [4.39260273, 13.88142961, 26.72105044, 19.62510644, 23.18417474]),
            (1.0, &[(1.0, 1.5), (0.9, 1.0)][..], [-0.429461587, -1.42197627, -2.96349688, -6.43153000, -41.8030310]),
            (1.0, &[(1.0, 1.5)][..], [3.83323350, 11.8412882, 21.0575587, 33.2177294, 54.5763392]),
        ] {
            for (b, degrees) in HEIGHTS.into_iter().zip(expected) {
                close(passage(n0, shells, b).degrees, degrees, 1e-8);
            }
        }
        for (b, degrees) in [(0.1, -3.84231624), (0.3, -12.2286480), (0.5, -23.5950089), (0.7, -48.9926383)] {
            close(passage(1.333, &[(1.0, 1.0)], b).degrees, degrees, 1e-8);
        }
        assert_eq!(passage(1.333, &[(1.0, 1.0)], 0.9).crossings, 0);
        assert!(passage(1.333, &[(1.0, 1.0)], 0.9).is_reflected);
        // The last of the hollow ball meets its inside at the critical angle exactly.
        assert!(passage(1.0, &[(1.0, 1.5), (0.9, 1.0)], 0.9).is_marginal && !passage(1.0, &a, 0.7).is_marginal);
        assert!(passage(1.0, &a, 0.7).is_reflected && !passage(1.0, &a, 0.5).is_reflected);
        close(passage(1.0, &[(1.0, 1.5), (1.0 - 1e-6, 1.0)], 0.5).degrees, -2.56453e-5, 2e-6);
        for (count, half, quarter) in
            [(10, 29.6432634, 14.9232303), (100, 29.6749795, 14.6892687), (1000, 29.5495953, 14.3609488)]
        {
            close(passage(1.0, &graded(count, luneburg), 0.5).degrees, half, 1e-8);
            close(passage(1.0, &graded(count, luneburg), 0.25).degrees, quarter, 1e-8);
        }
        for (count, degrees) in [(10, 132.100161), (100, 170.127654), (1000, 172.103821)] {
            close(passage(1.0, &graded(count, eaton), 0.5).degrees, degrees, 1e-8);
        }
        for b in HEIGHTS {
            let bubble = passage(1.333, &[(1.0, 1.0)], b / 1.333);
            close(bubble_deflection(1.333 - 1.0, b / 1.333).to_degrees(), bubble.degrees, 1e-12);
            close(ball_deflection(0.5, b).to_degrees(), passage(1.0, &[(1.0, 1.5)], b).degrees, 1e-12);
        }
    }

    #[test]
    fn furnaces_prisms_and_rainbows() {
        for (vertices, deficit, digits) in
            [(4, 3.50e-3, 2e-3), (8, 3.08e-4, 2e-3), (16, 3.3e-5, 2e-2), (64, 4.7e-7, 2e-2)]
        {
            close(furnace_deficit(1.5, vertices), deficit, digits);
        }
        close(radiance_in_ball(1.5, 0.9), 0.738470238, 1e-8);
        close(radiance_in_ball(1.333, 0.0), 1.776889, 1e-12);
        for (world, ior, degrees) in [(1.0, 1.5, 37.1807558), (1.0, 1.333, 23.5950089), (1.333, 1.5, 8.47722885)] {
            close(prism_deviation(world, ior, 60.0), degrees, 1e-8);
        }
        close(rainbow(1.333), 137.921893, 1e-8);
        let expected = [0.0917779593, 0.835544400, 0.0611832167, 0.00799337706, 0.00196821288];
        for (share, expected) in shares_of_ball::<5>(1.5).into_iter().zip(expected) {
            close(share, expected, 1e-5);
        }
        close(absorbing_ball(1.0), 0.296997075, 1e-8);
        close(absorbing_ball(0.01), 0.986766136, 1e-8);
        close(lateral_shift(1.5, 30.0), 0.193813782, 1e-8);
        close(lateral_shift(1.5, 45.0), 0.329142308, 1e-8);
    }
}
