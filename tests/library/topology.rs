//! Meshes with planted faults: each is found, named, placed and, where the intent is plain, repaired.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use iorect::geometry::topology::{FindingKind, NONE};
use iorect::geometry::{Enclosure, Geometry, Mesh, Part, Topology};
use iorect::scene::compile::compile;
use iorect::scene::description::{Description, Shape, Transform};
use iorect::scene::shapes::tessellate;
use iorect::tracking::Mode;

use crate::common::{self, joined, reversed};

use FindingKind::*;

fn shape(shape: &Shape) -> Mesh {
    tessellate(shape).unwrap().unwrap()
}

fn icosphere(center: DVec3, radius: f64, subdivisions: u32) -> Mesh {
    let mut mesh = shape(&Shape::Icosphere { center, radius, subdivisions });
    mesh.normals.clear();
    mesh
}

fn ball() -> Mesh {
    icosphere(DVec3::ZERO, 1.0, 3)
}

/// Turned about an irregular axis, so that nothing is aligned with an axis.
fn tilted(mut mesh: Mesh) -> Mesh {
    let turn = DQuat::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7);
    mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
    mesh.normals.clear();
    mesh
}

/// A number for each face, irregular.
fn dice(face: usize) -> f64 {
    ((face as f64 + 1.0) * 0.754_877_666_246_693).fract()
}

/// Every triangle as a set of positions with its orientation, sorted: equal for meshes of the same surface.
fn surface(mesh: &Mesh) -> Vec<[[u64; 3]; 3]> {
    let mut triangles: Vec<_> = (mesh.triangles.iter())
        .map(|t| {
            let corners = t.map(|i| mesh.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits()));
            let least = (0..3).min_by_key(|&k| corners[k]).unwrap();
            [0, 1, 2].map(|k| corners[(least + k) % 3])
        })
        .collect();
    triangles.sort_unstable();
    triangles
}

/// The surface that is used for a mesh.
fn repaired(mesh: &Mesh, topology: &Topology) -> Mesh {
    topology.repaired.as_deref().unwrap_or(mesh).clone()
}

/// Kinds and counts.
fn found(topology: &Topology) -> Vec<(FindingKind, u64)> {
    topology.findings.iter().map(|f| (f.kind, f.count)).collect()
}

#[track_caller]
fn assert_is(mesh: &Mesh, enclosure: Enclosure, components: u32, findings: &[(FindingKind, u64)]) -> Topology {
    let topology = Topology::of_mesh(mesh);
    assert_eq!(
        (topology.enclosure, topology.components, &found(&topology)[..]),
        (enclosure, components, findings),
        "gap {}",
        topology.gap
    );
    assert_eq!(topology.component_of_face.len(), repaired(mesh, &topology).triangles.len());
    assert_eq!(topology.neighbours.len(), topology.component_of_face.len());
    topology
}

#[test]
fn sound_meshes_are_left_alone() {
    for mesh in [
        ball(),
        tilted(ball()),
        shape(&Shape::Box { min: DVec3::splat(-1.0), max: DVec3::ONE }),
        tilted(shape(&Shape::Torus { center: DVec3::ZERO, major: 2.0, minor: 0.5, segments: 40, rings: 20 })),
        shape(&Shape::Cylinder { center: DVec3::ZERO, radius: 1.0, height: 2.0, segments: 32 }),
        tilted(shape(&Shape::Lathe {
            profile: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.999, 3.0], [0.999, 0.2], [0.0, 0.2]],
            segments: 64,
        })),
    ] {
        let topology = assert_is(&mesh, Enclosure::Closed, 1, &[]);
        assert_eq!((topology.repaired.as_ref(), topology.gap), (None, 0.0));
        assert!((topology.volume / mesh.signed_volume() - 1.0).abs() < 1e-12);
        let faces = topology.vertices.iter().enumerate();
        for (index, face) in faces {
            for k in 0..3 {
                let other = topology.vertices[topology.neighbours[index][k] as usize];
                let edge = (face[(k + 1) % 3], face[k]);
                assert!((0..3).any(|j| (other[j], other[(j + 1) % 3]) == edge));
            }
        }
    }
}

#[test]
fn a_flipped_ball_is_turned_over() {
    let good = ball();
    let topology = assert_is(&reversed(good.clone()), Enclosure::Closed, 1, &[(InsideOut, 1)]);
    assert!(surface(&topology.repaired.clone().unwrap()) == surface(&good));
    assert!((topology.volume - good.signed_volume()).abs() < 1e-12);
    let place = topology.finding(InsideOut).unwrap();
    assert!(place.center.length() < 0.01 && (1.0..2.0).contains(&place.radius));
    // Its normals look outward again, too.
    let mut with_normals = reversed(good.clone());
    with_normals.ensure_normals();
    let fixed = Topology::of_mesh(&with_normals).repaired.unwrap();
    assert!(fixed.positions.iter().zip(&fixed.normals).all(|(p, n)| p.dot(*n) > 0.9));
    // Normals that were right although the faces were not stay as they are.
    with_normals.normals = with_normals.positions.iter().map(|p| p.normalize()).collect();
    assert_eq!(Topology::of_mesh(&with_normals).repaired.unwrap().normals, with_normals.normals);
}

#[test]
fn mixed_faces_are_turned_to_agree() {
    for share in [0.02, 0.5, 0.9] {
        let good = ball();
        let mut mixed = good.clone();
        let turned: Vec<usize> = (0..mixed.triangles.len()).filter(|&face| dice(face) < share).collect();
        turned.iter().for_each(|&face| mixed.triangles[face].swap(0, 1));
        let topology = assert_is(&mixed, Enclosure::Closed, 1, &[(MixedOrientation, turned.len() as u64)]);
        assert!(surface(&topology.repaired.unwrap()) == surface(&good));
    }
    // An open sheet is made to agree with most of itself.
    let mut sheet = grid(10);
    sheet.triangles[7].swap(1, 2);
    let topology = Topology::of_mesh(&sheet);
    assert!(surface(&topology.repaired.clone().unwrap()) == surface(&grid(10)));
    assert_eq!(topology.finding(MixedOrientation).unwrap().count, 1);
    let middle = sheet.triangles[7].iter().map(|&i| sheet.positions[i as usize]).sum::<DVec3>() / 3.0;
    assert!(topology.finding(MixedOrientation).unwrap().center.distance(middle) < 0.1, "said where");
}

/// A flat sheet of 2n² triangles, looking up.
fn grid(n: u32) -> Mesh {
    let positions =
        (0..=n).flat_map(|i| (0..=n).map(move |j| DVec3::new(f64::from(i), 0.0, f64::from(j)) / f64::from(n)));
    let at = |i, j| i * (n + 1) + j;
    let triangles = (0..n).flat_map(|i| {
        (0..n).flat_map(move |j| {
            let corners = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        })
    });
    Mesh { positions: positions.collect(), normals: Vec::new(), triangles: triangles.collect(), uvs: Vec::new() }
}

#[test]
fn duplicates_and_double_faces_are_taken_out() {
    let good = ball();
    let mut doubled = good.clone();
    doubled.triangles.extend_from_slice(&good.triangles[10..30]);
    doubled.triangles.push(good.triangles[12]);
    let topology = assert_is(&doubled, Enclosure::Closed, 1, &[(DuplicateTriangles, 21)]);
    assert!(surface(&topology.repaired.unwrap()) == surface(&good));

    // A flap of no thickness on the ball, by vertices of its own.
    let mut flapped = good.clone();
    flapped = joined([
        flapped,
        Mesh {
            positions: vec![DVec3::X * 3.0, DVec3::Y * 3.0, DVec3::Z * 3.0],
            normals: Vec::new(),
            triangles: vec![[0, 1, 2], [1, 0, 2]],
            uvs: Vec::new(),
        },
    ]);
    let topology = assert_is(&flapped, Enclosure::Closed, 1, &[(DoubleFaces, 1)]);
    assert!(surface(&topology.repaired.unwrap()) == surface(&good));

    // Duplicates that share an edge with everything else, by other vertices at the same places.
    let copies = Mesh { triangles: good.triangles[..5].to_vec(), ..good.clone() };
    let topology = assert_is(&joined([good.clone(), copies]), Enclosure::Closed, 1, &[(DuplicateTriangles, 5)]);
    assert!(surface(&topology.repaired.unwrap()) == surface(&good));

    // Every face written once for each side.
    let two_sided = joined([good.clone(), reversed(good.clone())]);
    let topology = assert_is(&two_sided, Enclosure::Closed, 1, &[(DoubleFaces, good.triangles.len() as u64)]);
    assert!(surface(&topology.repaired.unwrap()) == surface(&good));
}

#[test]
fn degenerate_faces_are_left_out() {
    let good = ball();
    let mut bad = good.clone();
    bad.triangles.insert(3, [5, 5, 7]);
    bad.triangles.push([1, 2, 1]);
    let topology = assert_is(&bad, Enclosure::Closed, 1, &[(DegenerateTriangles, 2)]);
    assert!(surface(&topology.repaired.unwrap()) == surface(&good));
    let nothing = Mesh { triangles: vec![[0, 0, 1]], ..good };
    let topology = Topology::of_mesh(&nothing);
    assert_eq!((topology.enclosure, topology.volume), (Enclosure::Sheet, 0.0));
    assert_eq!(found(&topology), [(DegenerateTriangles, 1), (ZeroVolume, 1)]);
}

#[test]
fn holes_and_sheets() {
    let good = icosphere(DVec3::ZERO, 1.0, 4);
    for (share, enclosure) in [(0.01, Enclosure::Holed), (0.05, Enclosure::Holed), (0.2, Enclosure::Holed)] {
        let mut mesh = good.clone();
        let mut face = 0;
        mesh.triangles.retain(|_| {
            face += 1;
            dice(face) >= share
        });
        let topology = Topology::of_mesh(&mesh);
        assert_eq!(topology.enclosure, enclosure);
        assert!((topology.gap / (share / (1.0 - share)) - 1.0).abs() < 0.2, "{}", topology.gap);
        assert!((topology.volume / good.signed_volume() - 1.0).abs() < 0.02);
        assert!(topology.findings.iter().any(|f| f.kind == OpenMesh));
        // The same, inside out.
        let inverted = Topology::of_mesh(&reversed(mesh.clone()));
        assert!(inverted.findings.iter().any(|f| f.kind == InsideOut));
        assert!(surface(&inverted.repaired.unwrap()) == surface(&mesh));
    }
    // A cylinder of unit radius: without its top, without both ends, a dish.
    let cylinder = |height: f64, ends: &[f64]| {
        let mut mesh = shape(&Shape::Cylinder { center: DVec3::ZERO, radius: 1.0, height, segments: 64 });
        let positions = mesh.positions.clone();
        mesh.triangles
            .retain(|t| !ends.iter().any(|end| t.iter().all(|&i| positions[i as usize].y == end * height / 2.0)));
        mesh
    };
    for (height, ends, enclosure, gap) in [
        (2.0, &[1.0][..], Enclosure::Holed, 1.0 / 5.0),
        (8.0, &[1.0, -1.0], Enclosure::Holed, 1.0 / 8.0),
        (1.0, &[1.0, -1.0], Enclosure::Sheet, 1.0),
        (0.2, &[1.0], Enclosure::Sheet, 1.0 / 1.4),
    ] {
        let mesh = cylinder(height, ends);
        let topology = Topology::of_mesh(&mesh);
        assert_eq!(topology.enclosure, enclosure, "{height} {ends:?}");
        assert!((topology.gap - gap).abs() < 0.003, "{} {gap}", topology.gap);
        let open = topology.finding(OpenMesh).unwrap();
        assert_eq!(open.count, 64 * ends.len() as u64);
        assert!(
            (open.center.y.abs() - height / 2.0).abs() < 1e-9 && (open.radius - 2.0_f64.sqrt()).abs() < 0.01,
            "at the rim"
        );
        if enclosure == Enclosure::Holed {
            assert!((topology.volume / (PI * height) - 1.0).abs() < 0.01);
        } else {
            assert_eq!(topology.volume, 0.0);
        }
    }
    let mut bowl = good.clone();
    bowl.triangles.retain(|t| t.iter().all(|&i| good.positions[i as usize].y < 0.05));
    assert_eq!(Topology::of_mesh(&bowl).enclosure, Enclosure::Sheet);
    let flat = assert_is(&grid(5), Enclosure::Sheet, 1, &[(OpenMesh, 20)]);
    assert!((flat.gap - 1.0).abs() < 1e-12);
    assert_is(&reversed(grid(5)), Enclosure::Sheet, 1, &[(OpenMesh, 20)]);
    assert_eq!(
        Topology::of_shape(&shape(&Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::X, edge_v: DVec3::Z })).enclosure,
        Enclosure::Sheet
    );
}

#[test]
fn components_apart_cavities_and_unions() {
    let at = |x: f64, radius: f64| icosphere(DVec3::X * x, radius, 2);
    let volume = |mesh: &Mesh| mesh.signed_volume();
    assert_is(&joined([at(0.0, 1.0), at(3.0, 1.0)]), Enclosure::Closed, 2, &[]);
    // One of two turned.
    let topology = assert_is(&joined([at(0.0, 1.0), reversed(at(3.0, 1.0))]), Enclosure::Closed, 2, &[(InsideOut, 1)]);
    assert!((topology.finding(InsideOut).unwrap().center.x - 3.0).abs() < 0.01);
    // A cavity, and a stone in it, and a bubble in that.
    let hollow = [at(0.0, 1.0), reversed(at(0.1, 0.7)), at(0.2, 0.4), reversed(at(0.2, 0.2))];
    let topology = assert_is(&joined(hollow[..2].to_vec()), Enclosure::Closed, 2, &[(Cavity, 1)]);
    assert!((topology.volume / (volume(&at(0.0, 1.0)) - volume(&at(0.0, 0.7))) - 1.0).abs() < 1e-9);
    assert_is(&joined(hollow.clone()), Enclosure::Closed, 4, &[(Cavity, 2)]);
    // The same in another order, and all of it inside out.
    assert_is(&joined(hollow.iter().rev().cloned()), Enclosure::Closed, 4, &[(Cavity, 2)]);
    let inverted = reversed(joined(hollow.clone()));
    let topology = assert_is(&inverted, Enclosure::Closed, 4, &[(InsideOut, 4), (Cavity, 2)]);
    assert!(surface(&topology.repaired.unwrap()) == surface(&joined(hollow)));
    // Only the outermost turned: the cavity stays one.
    let both_inward = joined([reversed(at(0.0, 1.0)), reversed(at(0.1, 0.7))]);
    assert_is(&both_inward, Enclosure::Closed, 2, &[(InsideOut, 1), (Cavity, 1)]);
    // Outward in outward.
    assert_is(&joined([at(0.0, 1.0), at(0.1, 0.7)]), Enclosure::Union, 2, &[(NestedComponents, 1)]);
    assert_is(
        &joined([at(0.0, 1.0), at(0.1, 0.7), reversed(at(0.1, 0.5))]),
        Enclosure::Union,
        3,
        &[(NestedComponents, 2)],
    );
    // Side by side within one cavity, side by side in the open next to a big one.
    assert_is(
        &joined([at(0.0, 3.0), reversed(at(1.5, 0.7)), reversed(at(-1.5, 0.7))]),
        Enclosure::Closed,
        3,
        &[(Cavity, 2)],
    );
    assert_is(&joined((0..40).map(|i| at(f64::from(i) * 2.5, 1.0))), Enclosure::Closed, 40, &[]);
}

#[test]
fn many_bubbles_are_quick() {
    let mut parts = vec![icosphere(DVec3::ZERO, 40.0, 5)];
    for i in 0..20_i32.pow(3) {
        let place = DVec3::new(f64::from(i % 20), f64::from(i / 20 % 20), f64::from(i / 400)) - 9.5;
        parts.push(reversed(icosphere(place * 2.1, 0.7, 0)));
    }
    let start = std::time::Instant::now();
    assert_is(&joined(parts), Enclosure::Closed, 8001, &[(Cavity, 8000)]);
    println!("8000 bubbles, {} ms", start.elapsed().as_millis());
}

#[test]
fn crossings() {
    let at = |x: f64, radius: f64| icosphere(DVec3::X * x, radius, 3);
    let topology = Topology::of_mesh(&joined([at(0.0, 1.0), at(1.2, 0.8)]));
    assert_eq!(topology.enclosure, Enclosure::Union);
    let crossing = topology.finding(SelfIntersection).unwrap();
    // On the circle in which the spheres cross, x = (1 + 1.44 − 0.64) / 2.4 = 0.75.
    assert!((crossing.center.x - 0.75).abs() < 0.15 && crossing.count > 20, "{crossing:?}");
    assert!((crossing.center.length() - 1.0).abs() < 0.15 && crossing.radius < 0.3);

    // A tube that runs through itself: its middle line is a figure of eight that closes.
    let (segments, rings) = (120_u32, 16_u32);
    let middle = |k: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(segments)).sin_cos();
        DVec3::new(2.0 * cos, 0.05 * sin, 2.0 * sin * cos)
    };
    let mut tube = Mesh::default();
    for k in 0..segments {
        let along = (middle(k + 1) - middle(k + segments - 1)).normalize();
        let side = along.cross(DVec3::Y).normalize();
        let up = side.cross(along);
        for ring in 0..rings {
            let (sin, cos) = (2.0 * PI * f64::from(ring) / f64::from(rings)).sin_cos();
            tube.positions.push(middle(k) + (side * cos + up * sin) * 0.3);
        }
    }
    for k in 0..segments {
        for ring in 0..rings {
            let at = |k: u32, ring: u32| k % segments * rings + ring % rings;
            let [a, b, c, d] = [at(k, ring), at(k, ring + 1), at(k + 1, ring + 1), at(k + 1, ring)];
            tube.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if tube.signed_volume() < 0.0 {
        tube.reverse();
    }
    let topology = Topology::of_mesh(&tube);
    assert_eq!((topology.enclosure, topology.components), (Enclosure::Union, 1));
    let crossing = topology.finding(SelfIntersection).expect("it runs through itself");
    assert!(crossing.center.length() < 0.8, "in the middle: {}", crossing.center);

    // Boxes that touch along a face, or in part of one, or overlap with faces in common planes: no crossing is claimed, but membership
    // is not asked by first hits.
    let cuboid = |min: DVec3, max: DVec3| Mesh { normals: Vec::new(), ..shape(&Shape::Box { min, max }) };
    let one = cuboid(DVec3::ZERO, DVec3::ONE);
    let partly = cuboid(DVec3::new(1.0, 0.25, 0.25), DVec3::new(2.0, 0.75, 0.75));
    assert_is(&joined([one.clone(), partly]), Enclosure::Union, 2, &[]);
    let overlapping = cuboid(DVec3::new(0.5, 0.0, 0.0), DVec3::new(1.5, 1.0, 1.0));
    assert_eq!(Topology::of_mesh(&joined([one.clone(), overlapping])).enclosure, Enclosure::Union);
    // Near, but apart; and so near that vertices in single precision cannot keep them apart.
    for (gap, enclosure) in [(1e-5, Enclosure::Closed), (1e-9, Enclosure::Union)] {
        let near = cuboid(DVec3::new(1.0 + gap, 0.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
        assert_is(&tilted(joined([one.clone(), near])), enclosure, 2, &[]);
    }
    // A face in common: both copies go, and one box is left.
    let next = cuboid(DVec3::X, DVec3::new(2.0, 1.0, 1.0));
    let topology = Topology::of_mesh(&joined([one, next]));
    assert!((topology.volume - 2.0).abs() < 1e-12, "{:?}", found(&topology));
}

#[test]
fn a_moebius_strip_stays_as_it_is() {
    let (segments, rows) = (60_u32, 4_u32);
    let mut strip = Mesh::default();
    for k in 0..segments {
        let turn = PI * f64::from(k) / f64::from(segments);
        for row in 0..=rows {
            let out = (f64::from(row) / f64::from(rows) - 0.5) * 0.8;
            let (sin, cos) = (2.0 * turn).sin_cos();
            let radius = 2.0 + out * turn.cos();
            strip.positions.push(DVec3::new(radius * cos, out * turn.sin(), radius * sin));
        }
    }
    let at = |k: u32, row: u32| if k < segments { k * (rows + 1) + row } else { rows - row };
    for k in 0..segments {
        for row in 0..rows {
            let corners = [at(k, row), at(k + 1, row), at(k + 1, row + 1), at(k, row + 1)];
            strip.triangles.extend([[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]);
        }
    }
    let topology = Topology::of_mesh(&strip);
    assert_eq!((topology.enclosure, topology.repaired.as_ref()), (Enclosure::Sheet, None));
    assert_eq!(topology.finding(OneSided).unwrap().count, 1);
    assert!(topology.finding(MixedOrientation).is_none());
}

#[test]
fn slits_slivers_and_edges_of_many_faces() {
    // A vertex on the edge of another face: a slit without area.
    let mut slit = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::X / 2.0],
        normals: Vec::new(),
        triangles: vec![[0, 2, 4], [4, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]],
        uvs: Vec::new(),
    };
    let topology = Topology::of_mesh(&slit);
    assert_eq!(topology.enclosure, Enclosure::Closed);
    assert_eq!(found(&topology), [(OpenMesh, 3)]);
    assert!((topology.volume - 1.0 / 6.0).abs() < 1e-15);
    // Filled with a face without area it is closed.
    slit.triangles.push([0, 4, 1]);
    assert_eq!(found(&Topology::of_mesh(&slit)), []);

    // Needles: a cone over a polygon that is a millionth as long.
    let needle = |segments| shape(&Shape::Lathe { profile: vec![[0.0, 0.0], [1e-6, 0.0], [0.0, 1.0]], segments });
    assert_is(&needle(512), Enclosure::Closed, 1, &[]);
    assert_is(&tilted(needle(512)), Enclosure::Closed, 1, &[]);
    // So many that the search for crossings is given up: then membership is asked in the way that is right with and without.
    let needle = tilted(needle(8192));
    let start = std::time::Instant::now();
    assert_is(&needle, Enclosure::Union, 1, &[]);
    println!("a tilted needle of {} faces, {} ms", needle.triangles.len(), start.elapsed().as_millis());

    // Two boxes that share one edge, and two that share a wall.
    let cuboid = |min: DVec3, max: DVec3| Mesh { normals: Vec::new(), ..shape(&Shape::Box { min, max }) };
    let one = cuboid(DVec3::ZERO, DVec3::ONE);
    let diagonal = cuboid(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 1.0));
    assert_is(&joined([one.clone(), diagonal.clone()]), Enclosure::Union, 2, &[(NonManifold, 1)]);
    assert_is(&joined([one.clone(), reversed(diagonal)]), Enclosure::Union, 2, &[(InsideOut, 1), (NonManifold, 1)]);
    let mut walled = joined([one, cuboid(DVec3::X, DVec3::new(2.0, 1.0, 1.0))]);
    let positions = walled.positions.clone();
    let is_wall = |t: &[u32; 3]| t.iter().all(|&i| positions[i as usize].x == 1.0);
    let mut walls = 0;
    walled.triangles.retain(|t| {
        walls += usize::from(is_wall(t));
        !is_wall(t) || walls <= 2
    });
    let topology = Topology::of_mesh(&walled);
    assert_eq!(topology.enclosure, Enclosure::Holed, "{:?}", found(&topology));
    assert!(topology.finding(NonManifold).is_some());
}

/// A scene of one refractor made of a mesh.
fn scene(mesh: Mesh) -> Description {
    let mut description = common::empty(1.0);
    common::add(&mut description, Shape::mesh("m.ply", Arc::new(mesh)), 1.5, 0.0);
    description
}

#[test]
fn compiling_uses_the_repaired_mesh_and_remembers() {
    let mut description = scene(reversed(ball()));
    common::add(&mut description, Shape::Icosphere { center: DVec3::X * 5.0, radius: 1.0, subdivisions: 2 }, 1.4, 0.0);
    common::add(&mut description, common::sphere(DVec3::X * 9.0, 1.0), 1.4, 0.0);
    common::add(
        &mut description,
        Shape::Quad { center: DVec3::X * 12.0, edge_u: DVec3::X, edge_v: DVec3::Y },
        1.4,
        0.0,
    );
    let first = compile(&description, None).unwrap();
    assert!(first.topology_secs > 0.0);
    let corners = first.geometry.corners(0);
    assert!((corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0]) > 0.0, "it looks outward");
    assert!((first.objects[0].volume / ball().signed_volume() - 1.0).abs() < 1e-9);
    assert_eq!(first.objects[0].enclosure, Enclosure::Closed);
    assert_eq!((first.objects[2].topology.as_ref(), first.objects[2].enclosure), (None, Enclosure::Closed));
    assert_eq!((first.objects[3].volume, first.objects[3].enclosure), (f64::INFINITY, Enclosure::Sheet));

    let mut moved = description.clone();
    moved.objects.refractors_mut()[0].transform =
        Transform { scale: DVec3::new(2.0, -3.0, 0.5), ..Transform::IDENTITY };
    moved.objects.refractors_mut()[1].transform.translate = DVec3::Y;
    let second = compile(&moved, Some((&description, &first))).unwrap();
    for index in [0, 1, 3] {
        let [a, b] = [&first, &second].map(|w| w.objects[index].topology.as_ref().unwrap());
        assert!(Arc::ptr_eq(a, b), "object {index} is analysed once");
    }
    assert!((second.objects[0].volume / ball().signed_volume() / 3.0 - 1.0).abs() < 1e-9);
    let corners = second.geometry.corners(0);
    assert!(
        (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0]) > 0.0,
        "mirrored, it still looks outward"
    );
    // Another shape under the same name is another.
    let mut resized = moved.clone();
    resized.objects.refractors_mut()[1].shape =
        Shape::Icosphere { center: DVec3::X * 5.0, radius: 2.0, subdivisions: 2 };
    let third = compile(&resized, Some((&moved, &second))).unwrap();
    assert!((third.objects[1].volume / second.objects[1].volume - 8.0).abs() < 1e-6);
    // And what is remembered equals what is worked out anew.
    assert_eq!(compile(&resized, None).unwrap().objects, third.objects);
}

#[test]
fn holed_objects_can_be_asked_by_winding_number() {
    let mut mesh = icosphere(DVec3::X * 100.0, 1.0, 4);
    let mut face = 0;
    mesh.triangles.retain(|_| {
        face += 1;
        dice(face) >= 0.05
    });
    let compiled = compile(&scene(mesh), None).unwrap();
    assert_eq!(compiled.objects[0].enclosure, Enclosure::Holed);
    let winding = compiled.objects[0].winding.as_ref().unwrap();
    let center = DVec3::X * 100.0 - compiled.geometry.origin;
    for i in 0..1000 {
        let t = f64::from(i);
        let p = DVec3::new((t * 0.754_877).fract(), (t * 0.569_840).fract(), (t * 0.430_159).fract()) * 3.0 - 1.5;
        if (p.length() - 1.0).abs() > 0.1 {
            assert_eq!(winding.winding(center + p) > 0.5, p.length() < 1.0, "{p}");
        }
    }
    assert!(compile(&scene(ball()), None).unwrap().objects[0].winding.is_none());
}

/// Objects without any primitives: everything that is asked of a scene has an answer.
#[test]
fn refractors_of_nothing() {
    let nothing = Mesh { triangles: vec![[0, 0, 1]], ..ball() };
    for with_ball in [false, true] {
        let mut description = scene(nothing.clone());
        if with_ball {
            common::add(&mut description, common::sphere(DVec3::ZERO, 1.0), 1.5, 0.0);
        }
        let prepared = common::ready(description);
        let (geometry, objects) = (&prepared.scene.geometry, &prepared.scene.objects);
        assert_eq!((geometry.face_count(0), geometry.area(0)), (0, 0.0));
        assert_eq!(geometry.sample_surface(0, [0.5; 3]), None);
        assert_eq!((objects[0].volume, objects[0].enclosure), (f64::INFINITY, Enclosure::Sheet));
        assert_eq!(geometry.bounding_sphere().is_some(), with_ball);
        for mode in Mode::ALL {
            let film = common::render(&prepared, mode, (8, 8), 2, None);
            assert!(film.sums.iter().all(|sum| sum.is_finite()));
        }
        let problems = iorect::check::check(&prepared);
        assert!(
            problems.iter().any(|p| p.kind == "zero_volume" && p.message.contains("encloses nothing")),
            "{problems:?}"
        );
    }
}

/// Bad meshes made in memory are refused by name; nothing panics.
#[test]
fn impossible_meshes_are_refused() {
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = ball();
        change(&mut mesh);
        compile(&scene(mesh), None).map(|_| ()).unwrap_err().to_string()
    };
    for (message, word) in [
        (with(&|mesh| mesh.positions[7].y = f64::NAN), "not finite"),
        (with(&|mesh| mesh.positions[7].x = f64::INFINITY), "not finite"),
        (with(&|mesh| mesh.positions[7].x = 1e300), "beyond"),
        (with(&|mesh| mesh.triangles[9][1] = 1 << 31), "does not exist"),
        (with(&|mesh| mesh.triangles[9][1] = u32::MAX), "does not exist"),
        (with(&|mesh| mesh.triangles.clear()), "no triangles"),
        (with(&|mesh| mesh.normals = vec![DVec3::Y; 3]), "one normal for each vertex"),
    ] {
        assert!(message.contains("`object 0`") && message.contains(word), "{message}");
    }
    // A vertex that no face names may be anywhere that a vertex may be.
    let mut stray = ball();
    stray.positions.push(DVec3::splat(1e17));
    assert_is(&stray, Enclosure::Closed, 1, &[]);
    compile(&scene(stray), None).unwrap();
}

/// Files that promise billions of indices and hold none: refused at once, without room for them.
#[test]
fn false_counts_in_files() {
    let head = |faces: u64| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uint uint vertex_indices\nend_header\n"
        )
    };
    let vertices = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let body = |faces: u64, lists: &[&[u32]]| {
        let mut bytes = head(faces).into_bytes();
        vertices.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
        for list in lists {
            bytes.extend((list.len() as u32).to_le_bytes());
            list.iter().for_each(|i| bytes.extend(i.to_le_bytes()));
        }
        bytes
    };
    let folder = tempfile::tempdir().unwrap();
    let text = "[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n[[medium]]\nname = \"glass\"\nior = 1.5\n[[refractor]]\n\
                name = \"a\"\nmedium = \"glass\"\nshape = { mesh = \"m.ply\" }\n";
    let mut false_length = body(1, &[&[0, 1, 2]]);
    let place = false_length.len() - 16;
    false_length[place..place + 4].copy_from_slice(&(1_u32 << 31).to_le_bytes());
    for (bytes, word) in [
        (body(1 << 31, &[&[0, 1, 2]]), "promises"),
        (body(u64::MAX, &[]), "promises"),
        (false_length, "2147483648 corners"),
        (body(1, &[&[0, 1, 1 << 31]]), "names vertex 2147483648"),
        (body(1, &[&[0, 1, u32::MAX]]), "out of range"),
        (body(1, &[&[0; 20_000]]), "20000 corners"),
    ] {
        std::fs::write(folder.path().join("m.ply"), bytes).unwrap();
        let start = std::time::Instant::now();
        let error = iorect::formats::parse(text, &folder.path().join("s.toml"), &iorect::formats::Disk)
            .unwrap_err()
            .to_string();
        assert!(error.contains("m.ply") && error.contains(word), "{error}");
        assert!(start.elapsed().as_secs() < 10);
    }
    let polygon = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf".to_owned() + &" 1 2 3".repeat(10_000) + "\n";
    std::fs::write(folder.path().join("m.obj"), polygon).unwrap();
    let error =
        iorect::formats::parse(&text.replace("ply", "obj"), &folder.path().join("s.toml"), &iorect::formats::Disk)
            .unwrap_err();
    assert!(error.to_string().contains("m.obj:4") && error.to_string().contains("30000 corners"), "{error}");
}

/// Sheets, strips, scraps and flat bodies, and nothing else: a picture and a list of what is wrong.
#[test]
fn scenes_of_nothing_but_bad_meshes() {
    let flat = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
        normals: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        uvs: Vec::new(),
    };
    // Its faces lie on each other.
    let topology = assert_is(&flat, Enclosure::Union, 1, &[(ZeroVolume, 1)]);
    assert_eq!(topology.volume, 0.0);
    let mut scraps = ball();
    let mut face = 0;
    scraps.triangles.retain(|_| {
        face += 1;
        dice(face) < 0.1
    });
    assert_eq!(Topology::of_mesh(&scraps).enclosure, Enclosure::Sheet);
    let mut soup = ball();
    soup.triangles.iter_mut().enumerate().for_each(|(face, t)| {
        let step = (dice(face) * 640.0) as u32;
        t[2] = (t[2] + step) % 642;
    });
    let mut description = common::empty(1.33);
    for mesh in [flat, grid(4), scraps, soup, reversed(grid(3))] {
        let shape = Shape::mesh("m.obj", Arc::new(mesh));
        common::add(&mut description, shape, 1.5, 0.1);
    }
    let prepared = common::ready(description);
    for mode in Mode::ALL {
        let film = common::render(&prepared, mode, (16, 16), 4, Some(64));
        assert!(film.sums.iter().all(|sum| sum.is_finite()), "{mode:?}");
    }
    let problems = iorect::check::check(&prepared);
    for index in 0..5 {
        let name = format!("object {index}");
        assert!(problems.iter().any(|p| p.place == name), "nothing is said of {name}");
    }
}

/// What grows with the number of objects grows in proportion.
#[test]
fn many_objects() {
    let mut description = common::empty(1.0);
    let mesh = Arc::new(shape(&Shape::Box { min: DVec3::ZERO, max: DVec3::splat(0.5) }));
    for i in 0..20_000_u32 {
        let place = DVec3::new(f64::from(i % 50), f64::from(i / 50 % 50), f64::from(i / 2500));
        let shape = match i % 3 {
            0 => Shape::mesh("m.obj", Arc::clone(&mesh)),
            1 => Shape::Box { min: DVec3::ZERO, max: DVec3::splat(0.5) },
            _ => common::sphere(DVec3::splat(0.25), 0.25),
        };
        common::add(&mut description, shape, 1.5, 0.0);
        description.objects.refractors_mut().last_mut().unwrap().transform.translate = place;
    }
    let start = std::time::Instant::now();
    let scene = compile(&description, None).unwrap();
    let first = start.elapsed();
    let mut moved = description.clone();
    moved.objects.refractors_mut()[5].transform.translate.y -= 0.1;
    let start = std::time::Instant::now();
    let again = compile(&moved, Some((&description, &scene))).unwrap();
    println!(
        "20,000 objects: {} ms, of which topology {:.0} ms; one moved: {} ms, topology {:.0} ms",
        first.as_millis(),
        scene.topology_secs * 1e3,
        start.elapsed().as_millis(),
        again.topology_secs * 1e3
    );
    let distinct: std::collections::HashSet<_> =
        scene.objects.iter().filter_map(|o| o.topology.as_ref().map(Arc::as_ptr)).collect();
    assert_eq!(distinct.len(), 6_668, "objects of one mesh share its topology");
    assert!(scene.objects.iter().all(|o| o.enclosure == Enclosure::Closed && o.volume < 0.2));
}

/// How long it takes beside building the tree that rays walk; only said, never judged. More by `IORECT_SUBDIVISIONS` (up to 8: 1.3 million
/// triangles) and `IORECT_COPIES`.
#[test]
fn time_for_a_large_mesh() {
    let number = |name: &str, default: u32| std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(default);
    let ball = icosphere(DVec3::ZERO, 1.0, number("IORECT_SUBDIVISIONS", 6));
    let copies = (0..number("IORECT_COPIES", 1)).map(|i| {
        let mut copy = ball.clone();
        copy.positions.iter_mut().for_each(|p| *p += DVec3::X * f64::from(i) * 2.5);
        copy
    });
    let mesh = tilted(joined(copies));
    let clock = |f: &mut dyn FnMut()| {
        let start = std::time::Instant::now();
        f();
        start.elapsed().as_secs_f64() * 1e3
    };
    let of_shape = clock(&mut || assert_eq!(Topology::of_shape(&mesh).enclosure, Enclosure::Closed));
    let of_mesh = clock(&mut || assert_eq!(Topology::of_mesh(&mesh).enclosure, Enclosure::Closed));
    let parts = [Part::Mesh { mesh: mesh.clone(), smooth: false }];
    let tree = clock(&mut || assert_eq!(Geometry::build(&parts).triangle_count(), mesh.triangles.len()));
    println!(
        "{} triangles: topology {of_shape:.0} ms, with repair and crossings {of_mesh:.0} ms, tree {tree:.0} ms",
        mesh.triangles.len()
    );
    assert_eq!(Topology::of_mesh(&mesh).neighbours.iter().flatten().filter(|&&n| n == NONE).count(), 0);
}
