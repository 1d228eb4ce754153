//! Random meshes of several parts, in scenes with a few more refractors. What is written is a mesh as people have them: its parts touch, cross,
//! nest and repeat each other; seams are noisy; some look inside out or lack triangles. What is known of it are its parts, as clean solids:
//! the truth is their union, and needs no analysis.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use iorect::geometry::{Mesh, Ray};
use iorect::scene::description::{Description, Shape, Transform};

use super::parts::{self, Part};
use super::touch::{self, Kind, feature};
use super::truth::{Shell, Solid, Truth, winding_number};
use super::{Numbers, add, empty, sphere};

/// How the parts of a mesh stand to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// One part.
    Single,
    Apart,
    CornerTouch,
    EdgeTouch,
    FaceTouch,
    /// A tetrahedron fills a corner from inside.
    InTheCorner,
    /// A smaller one of the same kind inside, flush with some faces.
    FlushInside,
    /// Parts with a face in common, and identical triangles on it, both on the same side of it.
    RepeatedFaces,
    /// Whole parts, written twice or three times.
    RepeatedShells,
    /// A round part on a face of a polyhedron.
    Standing,
    Cross,
    /// Boxes on a coarse grid: they cross, and share planes.
    FlushCross,
    /// Within each other, all looking outward.
    Nested,
    /// Inward parts within outward ones, and parts within the cavities.
    Cavity,
    /// One of two parts looks inward and is no cavity.
    LoneReversed,
    /// A few of the triangles are missing.
    Holed,
}

impl Class {
    pub const ALL: [Self; 16] = [
        Self::Single,
        Self::Apart,
        Self::CornerTouch,
        Self::EdgeTouch,
        Self::FaceTouch,
        Self::InTheCorner,
        Self::FlushInside,
        Self::RepeatedFaces,
        Self::RepeatedShells,
        Self::Standing,
        Self::Cross,
        Self::FlushCross,
        Self::Nested,
        Self::Cavity,
        Self::LoneReversed,
        Self::Holed,
    ];

    /// As in `corner_touch`.
    pub fn name(self) -> String {
        let camel = format!("{self:?}");
        let words =
            camel.chars().flat_map(|c| if c.is_uppercase() { vec!['_', c.to_ascii_lowercase()] } else { vec![c] });
        words.skip(1).collect()
    }
}

/// How vertices are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    /// What stands at one place is one vertex, also of several parts.
    Welded,
    /// Each part for itself, with the vertices of its seams repeated.
    Seams,
    /// Each triangle for itself.
    Soup,
}

/// What moves the copies of a repeated vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Noise {
    None,
    /// Up to two units in the last place of each coordinate.
    Ulps,
    /// Up to two roundings of the largest coordinate.
    Roundings,
    /// Some 1e-33 beside each 0.
    BesideZero,
}

impl Noise {
    fn moved(self, numbers: &mut Numbers, p: DVec3) -> DVec3 {
        let mut moved = |x: f64| match self {
            Self::None => x,
            Self::Ulps => (0..numbers.index(5)).fold(x, |x, k| if k % 2 == 0 { x.next_up() } else { x }),
            Self::Roundings => x + numbers.between(-2.0, 2.0) * f64::EPSILON * p.abs().max_element(),
            Self::BesideZero if x == 0.0 => numbers.between(-1e-33, 1e-33),
            Self::BesideZero => x,
        };
        DVec3::new(moved(p.x), moved(p.y), moved(p.z))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Solid,
    /// Of the part with this index.
    CavityOf(usize),
}

/// Parts on their way into a mesh, about as large as a unit ball around the origin.
#[derive(Default)]
struct Assembly {
    parts: Vec<(Part, Role)>,
    /// Where they meet.
    focus: Vec<DVec3>,
    /// Triangles that look the wrong way, and triangles that are missing, by part.
    reversed: Vec<usize>,
    holed: Vec<usize>,
}

impl Assembly {
    fn add(&mut self, part: Part) -> usize {
        self.parts.push((part, Role::Solid));
        self.parts.len() - 1
    }

    fn of(numbers: &mut Numbers, class: Class) -> Self {
        let mut all = Self::default();
        match class {
            Class::Single => _ = all.add(parts::any(numbers, 1.0)),
            Class::Apart => all.scatter(numbers, 2.2),
            Class::Cross => all.scatter(numbers, 0.5),
            Class::CornerTouch | Class::EdgeTouch | Class::FaceTouch | Class::Standing => {
                let base = all.add(parts::polyhedron(numbers, 0.6));
                for _ in 0..1 + numbers.index(2) {
                    all.touch(numbers, base, class);
                }
            }
            Class::InTheCorner => {
                let base = all.add(parts::polyhedron(numbers, 1.0));
                for _ in 0..1 + numbers.index(2) {
                    let part = touch::in_the_corner(numbers, &all.parts[base].0);
                    all.add_beside(part, base);
                }
            }
            Class::FlushInside | Class::RepeatedFaces => {
                let base = all.add(parts::polyhedron(numbers, 1.0));
                for _ in 0..1 + numbers.index(2) {
                    let host = &all.parts[base].0;
                    let height = -numbers.between(0.1, 0.7) * host.radius();
                    let part = match (class, numbers.index(2)) {
                        (Class::RepeatedFaces, _) => touch::grown(numbers, host, height, 1.0),
                        (_, 0) => {
                            let scale = numbers.between(0.3, 0.9);
                            touch::grown(numbers, host, height, scale)
                        }
                        _ => {
                            let kind = [Kind::Corner, Kind::Edge, Kind::Face][numbers.index(3)];
                            let about = feature(numbers, host, kind).point;
                            touch::scaled_about(host, about, numbers.between(0.3, 0.9))
                        }
                    };
                    all.add_beside(part, base);
                }
            }
            Class::RepeatedShells => {
                let part = parts::any(numbers, 1.0);
                for _ in 0..2 + numbers.index(2) {
                    all.add(part.clone());
                }
                if numbers.index(2) == 0 {
                    all.scatter(numbers, 0.6);
                }
            }
            Class::FlushCross => {
                for _ in 0..2 + numbers.index(3) {
                    let mut on_grid = |low: usize, high: usize| (low + numbers.index(high - low)) as f64 * 0.5 - 1.0;
                    let min = DVec3::new(on_grid(0, 4), on_grid(0, 4), on_grid(0, 4));
                    let size = DVec3::new(on_grid(3, 6), on_grid(3, 6), on_grid(3, 6));
                    let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
                    let outline = outline.map(|(x, y)| min + size * DVec3::new(x, y, 0.0));
                    let part = Part::prism_over(numbers, &outline, DVec3::Z * size.z);
                    all.focus.push(part.middle());
                    all.add(part);
                }
            }
            Class::Nested | Class::Cavity => all.nest(numbers, class == Class::Cavity),
            Class::LoneReversed => {
                loop {
                    all = Self::default();
                    if numbers.index(2) == 0 {
                        let base = all.add(parts::polyhedron(numbers, 0.6));
                        all.touch(numbers, base, Class::CornerTouch);
                    } else {
                        let apart = [0.5, 2.2][numbers.index(2)];
                        all.scatter(numbers, apart);
                    }
                    if all.may_be_turned() {
                        break;
                    }
                }
                let last = all.parts.len() - 1;
                all.reversed.push(numbers.index(2) * last);
            }
            Class::Holed => {
                let part = fine(numbers);
                all.add(part);
                all.holed.push(0);
                if numbers.index(2) == 0 {
                    let apart = [0.5, 2.2][numbers.index(2)];
                    let part = if numbers.index(2) == 0 { fine(numbers) } else { parts::polyhedron(numbers, 0.8) };
                    let index = all.add(part.moved(&thrown(numbers, apart)));
                    if all.parts[index].0.triangles.len() > LEAST_OF_HOLED {
                        all.holed.push(index);
                    }
                }
            }
        }
        all
    }

    /// Two or three parts of any kind, about so far from each other.
    fn scatter(&mut self, numbers: &mut Numbers, apart: f64) {
        for _ in 0..2 + numbers.index(2) {
            let part = parts::any(numbers, 0.8);
            let at = thrown(numbers, apart * 0.8 * self.parts.len() as f64);
            self.focus.push(at.translation * 0.5);
            self.add(part.moved(&at));
        }
    }

    /// Adds a part whose points on those of part `base` are the same.
    fn add_beside(&mut self, mut part: Part, base: usize) {
        touch::snap(&mut part, &self.parts[base].0);
        self.focus.push(part.middle());
        self.add(part);
    }

    /// Adds a part that touches part `base` from outside.
    fn touch(&mut self, numbers: &mut Numbers, base: usize, class: Class) {
        let host = self.parts[base].0.clone();
        let kinds = |numbers: &mut Numbers| match class {
            Class::CornerTouch => {
                let other = [Kind::Corner, Kind::Corner, Kind::Edge, Kind::Face][numbers.index(4)];
                if numbers.index(2) == 0 { (Kind::Corner, other) } else { (other, Kind::Corner) }
            }
            Class::EdgeTouch => {
                [(Kind::Edge, Kind::Edge), (Kind::Edge, Kind::Face), (Kind::Face, Kind::Edge)][numbers.index(3)]
            }
            _ => (Kind::Face, Kind::Face),
        };
        let (own, of_host) = kinds(numbers);
        let at = feature(numbers, &host, of_host);
        let height = numbers.between(0.2, 0.8);
        let part = match (class, numbers.index(4)) {
            (Class::Standing, choice) => {
                let part = if choice < 2 { parts::cylinder(numbers, 0.5) } else { parts::round(numbers, 0.5) };
                let end = touch::lower_end(&part);
                touch::against(numbers, part, end, at, choice % 2 == 0)
            }
            (_, 0) if own == of_host => touch::mirrored(&host, at),
            (Class::FaceTouch, 1) => touch::grown(numbers, &host, height, 1.0),
            (Class::FaceTouch, 2) => {
                let scale = [0.5, 1.5, numbers.between(0.3, 2.0)][numbers.index(3)];
                touch::grown(numbers, &host, height, scale)
            }
            (Class::EdgeTouch, 1) => touch::on_an_edge(numbers, &host),
            _ => {
                let part = parts::polyhedron(numbers, 0.5);
                let own = feature(numbers, &part, own);
                let is_aligned = numbers.index(2) == 0;
                touch::against(numbers, part, own, at, is_aligned)
            }
        };
        self.focus.push(at.point);
        self.add_beside(part, base);
    }

    /// Whether it is clear what looks the wrong way when all is turned over, or one part is: an inward part within an inward one may be a part
    /// of a mesh that is inside out, or a cavity of one whose outer part is.
    fn may_be_turned(&self) -> bool {
        let has_cavities = self.parts.iter().any(|(_, role)| *role != Role::Solid);
        let is_within = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|k| &self.parts[k].0);
            let triangles: Vec<[DVec3; 3]> = b.corners().collect();
            // Its corners, moved inward by so much that rounding does not take them out where the parts touch.
            let corner = |p: &DVec3| p.lerp(a.middle(), 1e-6);
            a.points != b.points && a.points.iter().all(|p| winding_number(&triangles, corner(p)) > 0.01)
        };
        let count = self.parts.len();
        has_cavities || (0..count).all(|a| (0..count).all(|b| a == b || !is_within(a, b)))
    }

    /// Parts within each other.
    fn nest(&mut self, numbers: &mut Numbers, has_cavities: bool) {
        let host = match numbers.index(6) {
            0 => parts::torus(0.7, 0.3, 16, 9),
            1 => parts::icosphere(1.0, 1),
            2 => parts::cylinder(numbers, 1.0),
            _ => parts::polyhedron(numbers, 1.0),
        };
        let mut around = self.add(host);
        for depth in 0..1 + numbers.index(3) {
            let host = &self.parts[around].0;
            let part = if host.name == "torus" {
                let minor = 0.15 * 0.5_f64.powi(depth as i32);
                parts::torus(0.7, minor, 16, 7)
            } else {
                let middle = host.middle();
                let room = touch::room_around(host, middle);
                touch::fitting(numbers, middle, room)
            };
            self.focus.push(part.points[0]);
            // Every second one is material again.
            let role = if has_cavities && depth % 2 == 0 { Role::CavityOf(around) } else { Role::Solid };
            let is_host = !["torus", "knot", "lathe", "cone"].contains(&part.name) || self.parts[0].0.name == "torus";
            self.parts.push((part, role));
            around = self.parts.len() - 1;
            if !is_host {
                break;
            }
        }
    }
}

/// Fewer triangles make a part too coarse for holes: a single one that is missing is a large share.
const LEAST_OF_HOLED: usize = 150;

/// A part of many triangles.
fn fine(numbers: &mut Numbers) -> Part {
    loop {
        let part = parts::round(numbers, 0.9);
        if part.triangles.len() > LEAST_OF_HOLED {
            return part;
        }
    }
}

/// Turned anyhow, and moved so far.
fn thrown(numbers: &mut Numbers, far: f64) -> DAffine3 {
    DAffine3::from_mat3_translation(touch::turn(numbers), numbers.direction() * far)
}

/// What is known of a refractor with a mesh: its solids by the indices of its parts.
struct Known {
    refractor: usize,
    /// By part, in scene coordinates.
    triangles: Vec<Vec<[DVec3; 3]>>,
    roles: Vec<Role>,
    volume: f64,
    has_holes: bool,
}

/// A random scene, and what is known of it.
pub struct Case {
    pub description: Description,
    known: Vec<Known>,
    /// Size of the scene.
    scale: f64,
    /// Where parts meet, in scene coordinates.
    focus: Vec<DVec3>,
    label: String,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.label)
    }
}

/// Turn, size and place of a whole scene.
struct Placement {
    turn: DMat3,
    scale: f64,
    center: DVec3,
}

impl Placement {
    fn random(numbers: &mut Numbers) -> Self {
        let turn = if numbers.index(3) == 0 { DMat3::IDENTITY } else { touch::turn(numbers) };
        let scale = match numbers.index(3) {
            0 => 10.0_f64.powi(numbers.index(13) as i32 - 6),
            _ => 1.0,
        };
        let far = [0.0, 0.0, 1.0, 1e2, 1e4, 1e6][numbers.index(6)];
        Self { turn, scale, center: numbers.direction() * (far * scale) }
    }

    fn map(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(self.turn * self.scale, self.center)
    }
}

impl Case {
    pub fn new(seed: u64, class: Class) -> Self {
        let mut numbers = Numbers(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (class as u64) << 7);
        numbers.next();
        let numbers = &mut numbers;
        let placement = Placement::random(numbers);
        let mut case = Self {
            description: empty([1.0, 1.0, 1.333][numbers.index(3)]),
            known: Vec::new(),
            scale: placement.scale,
            focus: Vec::new(),
            label: String::new(),
        };
        let assembly = Assembly::of(numbers, class);
        let others = [0, 0, 1, 1, 2][numbers.index(5)];
        let place = numbers.index(others + 1);
        let copied = assembly.parts[numbers.index(assembly.parts.len())].0.clone();
        for index in 0..=others {
            if index == place {
                case.add_mesh(numbers, &assembly, &placement);
            } else {
                case.add_other(numbers, &copied, &placement);
            }
        }
        case.focus = assembly.focus.iter().map(|p| placement.map().transform_point3(*p)).collect();
        case.tell_apart_by_priority(numbers);
        case
    }

    fn add_mesh(&mut self, numbers: &mut Numbers, assembly: &Assembly, placement: &Placement) {
        let style = [Style::Welded, Style::Seams, Style::Seams, Style::Soup][numbers.index(4)];
        let noise = [Noise::None, Noise::Ulps, Noise::Roundings, Noise::BesideZero][numbers.index(4)];
        let is_inside_out = assembly.may_be_turned() && numbers.index(5) == 0;
        let is_mirrored = assembly.may_be_turned() && numbers.index(4) == 0;
        let is_shuffled = numbers.index(2) == 0;
        // The place is written into the vertices or into the transform. Vertices that are mirrored look inward: their triangles are not turned.
        let (mesh_from_part, transform) = if numbers.index(2) == 0 {
            let flip = if is_mirrored { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
            let scale = flip * placement.scale;
            let rotate = DVec3::new(numbers.between(-90.0, 90.0), numbers.between(-90.0, 90.0), 30.0);
            (DAffine3::from_mat3(placement.turn), Transform { scale, rotate, translate: placement.center })
        } else {
            let flip = DMat3::from_diagonal(if is_mirrored { DVec3::new(1.0, -1.0, 1.0) } else { DVec3::ONE });
            (placement.map() * DAffine3::from_mat3(flip), Transform::IDENTITY)
        };
        let mut mesh = Mesh::default();
        let mut known: Vec<Vec<[DVec3; 3]>> = Vec::new();
        let mut vertex_at: HashMap<[u64; 3], u32> = HashMap::new();
        let scene_from_part = transform.matrix() * mesh_from_part;
        for (index, (part, role)) in assembly.parts.iter().enumerate() {
            let is_holed = assembly.holed.contains(&index);
            let missing = if is_holed { numbers.between(0.005, 0.04) } else { 0.0 };
            let mut copies = vec![0; part.points.len()];
            part.written.iter().for_each(|written| copies[written.0 as usize] += 1);
            let mut index_of_written: Vec<Option<u32>> = vec![None; part.written.len()];
            let mut kept = Vec::new();
            for (triangle, corners) in part.triangles.iter().zip(part.corners()) {
                if numbers.next() < missing {
                    continue;
                }
                kept.push(corners.map(|p| scene_from_part.transform_point3(p)));
                let mut vertex = |written: u32| {
                    let (point, raw) = part.written[written as usize];
                    let clean = mesh_from_part.transform_point3(part.points[point as usize]);
                    let mut push = |p: DVec3| {
                        mesh.positions.push(p);
                        mesh.positions.len() as u32 - 1
                    };
                    match style {
                        Style::Welded => {
                            let key = clean.to_array().map(|x| (x + 0.0).to_bits());
                            *vertex_at.entry(key).or_insert_with(|| push(clean))
                        }
                        Style::Soup => push(noise.moved(numbers, clean)),
                        Style::Seams => *index_of_written[written as usize].get_or_insert_with(|| {
                            let raw = mesh_from_part.transform_point3(raw);
                            push(if copies[point as usize] > 1 { noise.moved(numbers, raw) } else { raw })
                        }),
                    }
                };
                let mut triangle = triangle.map(&mut vertex);
                let is_cavity = matches!(role, Role::CavityOf(_));
                if is_cavity ^ assembly.reversed.contains(&index) ^ is_inside_out {
                    triangle.swap(1, 2);
                }
                mesh.triangles.push(triangle);
            }
            if scene_from_part.matrix3.determinant() < 0.0 {
                kept.iter_mut().for_each(|t| t.swap(1, 2));
            }
            known.push(kept);
        }
        if is_shuffled {
            for k in (1..mesh.triangles.len()).rev() {
                mesh.triangles.swap(k, numbers.index(k + 1));
            }
        }
        let names: Vec<&str> = assembly.parts.iter().map(|(part, _)| part.name).collect();
        self.label = format!(
            "{} as {style:?} with noise {noise:?}{}{}{}, scale {:e}, {:e} away",
            names.join(" + "),
            if is_inside_out { ", inside out" } else { "" },
            if is_mirrored { ", mirrored" } else { "" },
            if is_shuffled { ", shuffled" } else { "" },
            placement.scale,
            placement.center.length() / placement.scale,
        );
        let roles: Vec<Role> = assembly.parts.iter().map(|(_, role)| *role).collect();
        let has_holes = !assembly.holed.is_empty();
        let shape = Shape::mesh("made.ply", Arc::new(mesh));
        self.add(numbers, shape);
        self.description.objects.refractors_mut().last_mut().unwrap().transform = transform;
        let refractor = self.description.objects.refractors().len() - 1;
        let volume = known.iter().zip(&roles).map(|(triangles, role)| {
            let volume = Shell::new(triangles.clone()).volume();
            if *role == Role::Solid { volume } else { -volume }
        });
        let volume = volume.sum();
        self.known.push(Known { refractor, triangles: known, roles, volume, has_holes });
    }

    fn add(&mut self, numbers: &mut Numbers, shape: Shape) {
        let ior = [1.0, 0.8, 2.4, numbers.between(1.2, 1.8), numbers.between(1.2, 1.8)][numbers.index(5)];
        add(&mut self.description, shape, ior, 0.0);
    }

    /// Another refractor: a ball somewhere, or a mesh of one part: any, or a copy of one of the first mesh's parts.
    fn add_other(&mut self, numbers: &mut Numbers, copied: &Part, placement: &Placement) {
        let radius =
            [numbers.between(0.1, 0.4), numbers.between(0.4, 1.0), numbers.between(1.5, 2.5)][numbers.index(3)];
        let at = numbers.direction() * numbers.between(0.0, 1.0);
        let choice = numbers.index(5);
        if choice < 2 {
            let center = placement.map().transform_point3(at);
            self.add(numbers, sphere(center, radius * placement.scale));
            return;
        }
        let part = if choice == 2 { copied.clone() } else { parts::any(numbers, radius).moved(&thrown(numbers, 0.6)) };
        let map = placement.map();
        let mesh = Mesh {
            positions: part
                .written
                .iter()
                .map(|(point, _)| map.transform_point3(part.points[*point as usize]))
                .collect(),
            normals: Vec::new(),
            triangles: part.triangles.clone(),
            uvs: Vec::new(),
        };
        let triangles: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect();
        self.add(numbers, Shape::mesh("other.ply", Arc::new(mesh)));
        let refractor = self.description.objects.refractors().len() - 1;
        let volume = Shell::new(triangles.clone()).volume();
        let (triangles, roles) = (vec![triangles], vec![Role::Solid]);
        self.known.push(Known { refractor, triangles, roles, volume, has_holes: false });
    }

    /// Overlaps are decided by volumes only where these are clear: parts that overlap count in full in a mesh's volume, but once in
    /// the union's, and of holes the volume depends on how they are closed.
    fn tell_apart_by_priority(&mut self, numbers: &mut Numbers) {
        let ranges: Vec<(f64, f64)> = (0..self.description.objects.refractors().len())
            .map(|index| match self.known.iter().find(|known| known.refractor == index) {
                Some(known) => {
                    let count = known.roles.len() as f64;
                    let low = if count > 1.0 { known.volume / (2.0 * count) } else { known.volume };
                    if known.has_holes { (0.7 * low, 1.4 * known.volume) } else { (low * 0.999, known.volume * 1.001) }
                }
                None => match self.description.objects.refractors()[index].shape {
                    Shape::Sphere { radius, .. } => [1.0; 2].map(|x: f64| x * 4.18879 * radius.powi(3)).into(),
                    _ => (0.0, f64::INFINITY),
                },
            })
            .collect();
        let is_doubtful =
            (0..ranges.len()).any(|i| (0..i).any(|j| ranges[i].0 <= ranges[j].1 && ranges[j].0 <= ranges[i].1));
        if is_doubtful || numbers.index(4) == 0 {
            let turn = numbers.index(3);
            for (index, refractor) in self.description.objects.refractor_roles_mut().enumerate() {
                refractor.priority = ((index + turn) % 3) as i32 - 1;
            }
        }
    }

    /// The truth about the scene, with vertices rounded as `origin`, the local origin of the scene's geometry, rounds them.
    pub fn truth(&self, origin: DVec3) -> Truth {
        self.truth_without(origin, None)
    }

    /// The same where the last part of the mesh with most parts is forgotten, or nothing is.
    pub fn truth_without(&self, origin: DVec3, forgotten: Option<usize>) -> Truth {
        let rounded = |p: DVec3| (p - origin).as_vec3().as_dvec3();
        self.known.iter().fold(Truth::new(&self.description).relative_to(origin), |truth, known| {
            let shell = |part: usize| Shell::new(known.triangles[part].iter().map(|t| t.map(rounded)).collect());
            let cavities = |part: usize| {
                (0..known.roles.len()).filter(|&other| known.roles[other] == Role::CavityOf(part)).map(shell).collect()
            };
            let solids = (0..known.roles.len())
                .filter(|&part| known.roles[part] == Role::Solid)
                .filter(|&part| known.roles.len() == 1 || forgotten != Some(part))
                .map(|part| Solid { shell: shell(part), cavities: cavities(part) })
                .collect();
            truth.with_solids(known.refractor, solids, known.volume, known.has_holes)
        })
    }

    /// Rays into and within the scene, half of them towards the places where parts meet.
    pub fn rays(&self, truth: &Truth, count: usize, seed: u64) -> Vec<Ray> {
        let mut numbers = Numbers(seed ^ 0x5DEE_CE66);
        let mut rays = truth.rays(count, seed);
        for ray in rays.iter_mut().step_by(2).filter(|_| !self.focus.is_empty()) {
            let aim =
                self.focus[numbers.index(self.focus.len())] + numbers.direction() * (0.2 * self.scale * numbers.next());
            let origin = aim + numbers.direction() * (5.0 * self.scale);
            *ray = Ray::new(origin, (aim - origin).normalize());
        }
        rays
    }
}
