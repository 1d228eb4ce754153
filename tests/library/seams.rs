//! Generated and exported meshes repeat the vertices of their seams, a few roundings apart: such a mesh is closed, looks the right way and is asked
//! as any closed one. Real holes stay holes, and are as large as what is missing.

use std::f64::consts::{PI, TAU};

use crate::common::{Numbers, case, ready};
use glam::DVec3;
use iorect::geometry::topology::FindingKind;
use iorect::geometry::{Enclosure, Mesh, Ray, Topology};
use iorect::tracking::Mode;
use iorect::transport::inspect::{Follow, VertexEvent, trace};

/// How the repeated vertices differ from those that they repeat.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Noise {
    /// Not at all.
    None,
    /// As f64's sine and cosine of 2π differ from those of 0.
    Natural,
    /// As those of f32 do.
    Single,
    /// By up to four units in the last place of f64, either way.
    Ulps,
    /// Zeros are 1e-33.
    Tiny,
}

const NOISES: [Noise; 5] = [Noise::None, Noise::Natural, Noise::Single, Noise::Ulps, Noise::Tiny];

/// A surface over (u, v) in [0, 1]², its first row and column repeated as its last, by vertices of their own.
struct Sheet {
    name: &'static str,
    columns: u32,
    rows: u32,
    /// Whether the last row is the first.
    has_two_seams: bool,
    at: fn(f64, f64) -> DVec3,
}

/// All look outward. Those with ends run to a point there, or have lids.
const SHEETS: [Sheet; 7] = [
    Sheet {
        name: "sphere",
        columns: 16,
        rows: 8,
        has_two_seams: false,
        at: |u, v| turned(u, (PI * v).sin(), -(PI * v).cos()),
    },
    Sheet {
        name: "lathe",
        columns: 24,
        rows: 12,
        has_two_seams: false,
        at: |u, v| turned(u, (PI * v).sin() * (1.0 + 0.4 * (7.0 * v).cos()), 3.0 * v),
    },
    Sheet {
        name: "cylinder",
        columns: 20,
        rows: 4,
        has_two_seams: false,
        at: |u, v| {
            turned(
                u,
                if v == 0.0 || v == 1.0 { 0.0 } else { 1.0 },
                if v < 0.5 { -1.0 } else { 1.0 } * f64::from(v != 0.5),
            )
        },
    },
    Sheet {
        name: "cone",
        columns: 20,
        rows: 2,
        has_two_seams: false,
        at: |u, v| turned(u, if v == 0.5 { 1.0 } else { 0.0 }, if v < 1.0 { -0.5 } else { 1.0 }),
    },
    Sheet {
        name: "capsule",
        columns: 16,
        rows: 9,
        has_two_seams: false,
        at: |u, v| turned(u, (PI * v).sin(), if v < 0.5 { -1.0 } else { 1.0 } - (PI * v).cos()),
    },
    Sheet {
        name: "torus",
        columns: 24,
        rows: 12,
        has_two_seams: true,
        at: |u, v| turned(u, 1.0 + 0.4 * (TAU * v).cos(), 0.4 * (TAU * v).sin()),
    },
    Sheet { name: "knot", columns: 96, rows: 8, has_two_seams: true, at: knot },
];

/// At the angle 2πu about the y axis, so that a sheet that goes up with v looks outward.
fn turned(u: f64, radius: f64, height: f64) -> DVec3 {
    DVec3::new(radius * (TAU * u).cos(), height, -radius * (TAU * u).sin())
}

/// A tube along a trefoil.
fn knot(u: f64, v: f64) -> DVec3 {
    let middle = |u: f64| {
        let t = TAU * u;
        DVec3::new(t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -(3.0 * t).sin())
    };
    let along = (middle(u + 1e-4) - middle(u - 1e-4)).normalize();
    let side = along.cross(DVec3::Z).normalize();
    let up = side.cross(along);
    middle(u) + (side * (TAU * v).cos() + up * (TAU * v).sin()) * 0.3
}

impl Sheet {
    fn mesh(&self, noise: Noise, numbers: &mut Numbers) -> Mesh {
        let (columns, rows) = (self.columns, self.rows);
        let place = |i: u32, j: u32| (self.at)(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
        let mut positions = Vec::new();
        for j in 0..=rows {
            for i in 0..=columns {
                let first = place(i % columns, if self.has_two_seams { j % rows } else { j });
                let is_repeated = i == columns || (self.has_two_seams && j == rows);
                positions.push(match noise {
                    Noise::None => first,
                    Noise::Natural => place(i, j),
                    Noise::Single => {
                        let noisy =
                            if is_repeated { first + DVec3::splat(1.5e-7) * numbers.direction() } else { first };
                        noisy.as_vec3().as_dvec3()
                    }
                    Noise::Ulps if is_repeated => {
                        let steps = |x: f64| x * (1.0 + (8.0 * numbers.next() - 4.0).round() * f64::EPSILON);
                        DVec3::from(first.to_array().map(steps))
                    }
                    Noise::Tiny if is_repeated => {
                        DVec3::from(first.to_array().map(|x| if x.abs() < 1e-15 { 1e-33 } else { x }))
                    }
                    Noise::Ulps | Noise::Tiny => first,
                });
            }
        }
        let at = |i: u32, j: u32| j * (columns + 1) + i;
        let quads =
            (0..rows).flat_map(|j| (0..columns).map(move |i| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        let triangles = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        Mesh { positions, normals: Vec::new(), triangles: triangles.collect(), uvs: Vec::new() }
    }
}

/// What the analysis made of it.
fn outcome(mesh: &Mesh) -> (Topology, Mesh) {
    let topology = Topology::of_mesh(mesh);
    let repaired = topology.repaired.as_deref().unwrap_or(mesh).clone();
    (topology, repaired)
}

fn assert_closed(mesh: &Mesh, volume: f64, what: &str) {
    let (topology, repaired) = outcome(mesh);
    // Rows of vertices at one point make faces that are lines: those are known to be none.
    let findings: Vec<FindingKind> =
        topology.findings.iter().map(|f| f.kind).filter(|kind| *kind != FindingKind::DegenerateTriangles).collect();
    assert_eq!(findings, [], "{what}");
    assert_eq!((topology.enclosure, topology.components), (Enclosure::Closed, 1), "{what}");
    assert!((topology.volume / volume - 1.0).abs() < 1e-5, "{what}: {} instead of {volume}", topology.volume);
    assert!(repaired.signed_volume() > 0.0, "{what}");
}

fn moved(mesh: &Mesh, scale: DVec3, offset: DVec3) -> Mesh {
    Mesh { positions: mesh.positions.iter().map(|p| *p * scale + offset).collect(), ..mesh.clone() }
}

#[test]
fn repeated_seams_are_closed_wherever_the_mesh_stands() {
    let mut numbers = Numbers(1);
    for sheet in &SHEETS {
        let volume = sheet.mesh(Noise::None, &mut numbers).signed_volume();
        assert!(volume > 0.0, "{}", sheet.name);
        for noise in NOISES {
            let mesh = sheet.mesh(noise, &mut numbers);
            for scale in [1e-6, 1.0, 1e6] {
                for far in [0.0, 1.0, 1e3, 1e6] {
                    let name = format!("{} {noise:?} {scale} {far}", sheet.name);
                    let offset = DVec3::new(0.7, -0.4, 1.0) * (far * scale);
                    assert_closed(&moved(&mesh, DVec3::splat(scale), offset), volume * scale.powi(3), &name);
                }
            }
        }
    }
}

#[test]
fn files_in_single_precision_far_from_the_origin() {
    let mut numbers = Numbers(2);
    for sheet in &SHEETS {
        let volume = sheet.mesh(Noise::None, &mut numbers).signed_volume();
        for far in [10.0, 100.0, 1000.0] {
            let mesh = moved(&sheet.mesh(Noise::Natural, &mut numbers), DVec3::ONE, DVec3::new(far, -far, 0.3 * far));
            let positions = mesh.positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
            let (topology, _) = outcome(&Mesh { positions, ..mesh });
            assert!(matches!(topology.enclosure, Enclosure::Closed | Enclosure::Union), "{} {far}", sheet.name);
            assert!(topology.finding(FindingKind::OpenMesh).is_none(), "{} {far}", sheet.name);
            assert!((topology.volume / volume - 1.0).abs() < 0.01, "{} {far}", sheet.name);
        }
    }
}

#[test]
fn mirrored_and_inside_out_ones_are_turned_over() {
    let mut numbers = Numbers(3);
    for sheet in &SHEETS {
        for noise in NOISES {
            let good = sheet.mesh(noise, &mut numbers);
            let mut turned = good.clone();
            turned.reverse();
            let mirrored = moved(&good, DVec3::new(1.0, 1.0, -1.0), DVec3::X * 3.0);
            for mesh in [turned, mirrored] {
                let (topology, repaired) = outcome(&mesh);
                assert_eq!(
                    (topology.enclosure, topology.components),
                    (Enclosure::Closed, 1),
                    "{} {noise:?}",
                    sheet.name
                );
                assert!(topology.finding(FindingKind::InsideOut).is_some(), "{} {noise:?}", sheet.name);
                assert!(repaired.signed_volume() > 0.0, "{} {noise:?}", sheet.name);
            }
        }
    }
}

/// No two vertices of a mesh that was joined are near each other and not equal: rays must find no crack there.
#[test]
fn joined_vertices_are_equal_to_the_bit() {
    let mut numbers = Numbers(4);
    for sheet in &SHEETS {
        for noise in NOISES {
            let (topology, repaired) = outcome(&sheet.mesh(noise, &mut numbers));
            for (face, welded) in repaired.triangles.iter().zip(&topology.vertices) {
                for k in 0..3 {
                    let [a, b] = [face[k], welded[k]].map(|v| repaired.positions[v as usize]);
                    assert_eq!(a, b, "{} {noise:?}", sheet.name);
                }
            }
        }
    }
}

/// Thin shells and small gaps between different parts stay apart: only open rims are joined.
#[test]
fn thin_shells_and_small_gaps_stay_apart() {
    let mut numbers = Numbers(5);
    for sheet in &SHEETS {
        let outer = sheet.mesh(Noise::Ulps, &mut numbers);
        let mut inner = moved(&outer, DVec3::splat(1.0 - 1e-6), DVec3::ZERO);
        inner.reverse();
        let count = outer.positions.len() as u32;
        let shell = Mesh {
            positions: outer.positions.iter().chain(&inner.positions).copied().collect(),
            normals: Vec::new(),
            triangles: (outer.triangles.iter().copied())
                .chain(inner.triangles.iter().map(|t| t.map(|v| v + count)))
                .collect(),
            uvs: Vec::new(),
        };
        let (topology, _) = outcome(&shell);
        // A tube that is shrunk about another point than its middle line crosses itself.
        if !sheet.has_two_seams {
            assert_eq!(topology.components, 2, "{}", sheet.name);
            assert!((topology.volume / (3e-6 * outer.signed_volume()) - 1.0).abs() < 0.01, "{}", sheet.name);
        }
        assert!(topology.finding(FindingKind::OpenMesh).is_none(), "{}", sheet.name);
    }
}

#[test]
fn holes_are_as_large_as_what_is_missing() {
    let mut numbers = Numbers(6);
    let area = |mesh: &Mesh, faces: &[[u32; 3]]| -> f64 {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
        faces.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    };
    for sheet in &SHEETS {
        for noise in NOISES {
            let whole = sheet.mesh(noise, &mut numbers);
            let per_row = 2 * sheet.columns as usize;
            let middle = sheet.rows as usize / 2;
            // A row all round, half a row, a column from end to end, one triangle.
            let is_missing: [&dyn Fn(usize) -> bool; 4] = [
                &|face| face / per_row == middle,
                &|face| face / per_row == middle && face % per_row < per_row / 2,
                &|face| face % per_row / 2 == 3,
                &|face| face == per_row * middle + 7,
            ];
            for (kind, is_missing) in is_missing.into_iter().enumerate() {
                let (mut gone, mut left) = (Vec::new(), Vec::new());
                for (face, triangle) in whole.triangles.iter().enumerate() {
                    if is_missing(face) { gone.push(*triangle) } else { left.push(*triangle) }
                }
                let share = area(&whole, &gone) / area(&whole, &left);
                // Faces without area; and more than half of all, which something smaller closes.
                if !(1e-9..0.5).contains(&share) {
                    continue;
                }
                let (topology, _) = outcome(&Mesh { triangles: left, ..whole.clone() });
                let ratio = topology.gap / share;
                assert!((0.7..1.1).contains(&ratio), "{} {noise:?} {kind}: {} of {share}", sheet.name, topology.gap);
                assert!(topology.finding(FindingKind::OpenMesh).is_some(), "{} {noise:?} {kind}", sheet.name);
            }
        }
    }
}

/// A ring whose seam is repeated 2.4e-16 off, in a ball of water: what lies outside of it is the water.
#[test]
fn a_ring_with_a_repeated_seam_in_water() {
    let prepared = ready(case("torus-seam/nested.toml"));
    let ring = &prepared.table.patches[0];
    let name = |medium| prepared.scene.medium(medium).name.clone();
    assert_eq!((ring.outside.map(name), ring.inside.map(name)), (Some("water".into()), Some("glass".into())));
    assert_eq!(iorect::check::check(&prepared), []);
    for mode in [Mode::Stack, Mode::RectifiedObject, Mode::Rectified, Mode::Reference] {
        let ray = Ray::new(DVec3::new(1.0, 0.1, 5.0), DVec3::NEG_Z);
        let path = trace(&prepared, mode, ray, Follow::Transmit, 0, None);
        // Inside the ring it is totally reflected once.
        let crossed = path.vertices.iter().filter(|v| v.event == VertexEvent::Transmit);
        let media: Vec<[&str; 2]> =
            crossed.map(|v| [&v.from, &v.to].map(|medium| medium.as_deref().unwrap_or("nothing"))).collect();
        let expected = [["world", "water"], ["water", "glass"], ["glass", "water"], ["water", "world"]];
        assert_eq!(media, expected, "{mode}");
        assert_eq!(path.events.total(), 0, "{mode}");
    }
}
