//! What a path must meet, worked out apart from the program: every triangle and sphere is tried in turn, in f64; a point lies inside a mesh
//! where the solid angles of all its triangles say so; overlaps are resolved here once more; Snell's law is written in vectors. Of the
//! program it uses nothing but the shapes' tessellation and their transforms. Slow and simple.

use std::cell::Cell;
use std::f64::consts::PI;

use glam::DVec3;
use iorect::geometry::Ray;
use iorect::optics::Ior;
use iorect::scene::compile::compile;
use iorect::scene::description::{Description, Shape, Transform};
use iorect::scene::shapes::tessellate;
use iorect::tracking::Mode;
use iorect::tracking::Prepared;
use iorect::transport::inspect::{Follow, TracedPath, VertexEvent, trace};

use super::Numbers;

/// Triangles that look outward, or what is left of them where there are holes.
pub struct Shell {
    triangles: Vec<[DVec3; 3]>,
    min: DVec3,
    max: DVec3,
}

impl Shell {
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let min = triangles.iter().flatten().fold(DVec3::INFINITY, |m, p| m.min(*p));
        let max = triangles.iter().flatten().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
        Self { triangles, min, max }
    }

    /// Enclosed; of holes nothing is known.
    pub fn volume(&self) -> f64 {
        let middle = (self.min + self.max) / 2.0;
        self.triangles.iter().map(|t| (t[0] - middle).dot((t[1] - middle).cross(t[2] - middle)) / 6.0).sum()
    }

    /// Times that it encloses `point`; 0 beyond its bounding box.
    fn winding(&self, point: DVec3) -> f64 {
        let is_in_box = point.cmpge(self.min).all() && point.cmple(self.max).all();
        if is_in_box { winding_number(&self.triangles, point) } else { 0.0 }
    }
}

/// What a shell encloses, but for what the shells of its cavities enclose.
pub struct Solid {
    pub shell: Shell,
    pub cavities: Vec<Shell>,
}

impl Solid {
    fn shells(&self) -> impl Iterator<Item = &Shell> {
        std::iter::once(&self.shell).chain(&self.cavities)
    }

    fn shift(&mut self, by: DVec3) {
        for shell in std::iter::once(&mut self.shell).chain(&mut self.cavities) {
            shell.triangles.iter_mut().flatten().for_each(|p| *p += by);
            (shell.min, shell.max) = (shell.min + by, shell.max + by);
        }
    }

    fn contains(&self, point: DVec3) -> bool {
        self.shell.winding(point) > 0.5 && self.cavities.iter().all(|cavity| cavity.winding(point) < 0.5)
    }
}

enum Surface {
    Ball {
        center: DVec3,
        radius: f64,
    },
    /// The union of solids.
    Solids(Vec<Solid>),
}

struct Body {
    surface: Surface,
    /// Index into `Truth::media`; `None` for what is opaque.
    medium: Option<usize>,
    priority: i32,
    volume: f64,
    min: DVec3,
    max: DVec3,
}

pub struct Truth {
    /// In coordinates relative to `origin`.
    bodies: Vec<Body>,
    origin: DVec3,
    /// Names and indices of refraction; first the global medium.
    media: Vec<(String, f64)>,
    /// Size of the scene: the largest extent of its bounding box.
    pub size: f64,
    /// Surfaces nearer than this along a ray are one.
    pub together: f64,
    /// A path is followed no farther than a hit that lies nearer than this to an edge, a crossing curve or another surface, or one that is
    /// met at a cosine below `grazing`.
    pub margin: f64,
    pub grazing: f64,
    /// How overlaps are resolved. Made wrong on purpose by tests of the tests.
    top: fn(Candidate, Candidate) -> bool,
    /// Places so far where surfaces of several bodies, or of several parts of one, were one.
    coincident: Cell<usize>,
    /// Whether some shell has holes, through which a ray comes into it without meeting it.
    has_holes: bool,
}

/// A refractor that contains a point.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    pub index: usize,
    pub priority: i32,
    pub volume: f64,
}

/// Whether `b` fills a point that both contain: higher priority, then smaller volume, then later.
pub fn is_above(a: Candidate, b: Candidate) -> bool {
    let later = b.index > a.index;
    let are_same = (a.volume - b.volume).abs() <= 1e-6 * a.volume.min(b.volume);
    match (a.priority == b.priority, are_same) {
        (false, _) => b.priority > a.priority,
        (true, false) => b.volume < a.volume,
        (true, true) => later,
    }
}

/// One meeting with a surface.
#[derive(Clone, Copy)]
struct Meeting {
    t: f64,
    /// Unit, outward.
    normal: DVec3,
    /// Distance to the nearest edge; infinite on spheres.
    edge: f64,
    body: usize,
    /// Which of the body's shells.
    shell: usize,
}

/// The next thing on a ray that is more than a surface between equals.
struct Next {
    position: DVec3,
    /// Unit, outward.
    normal: DVec3,
    from: usize,
    /// `None`: opaque.
    to: Option<usize>,
}

enum Found {
    Nothing,
    Next(Next),
    /// Too close to an edge, another surface, or grazing.
    IllConditioned,
}

impl Truth {
    pub fn new(description: &Description) -> Self {
        let index_of = |ior: &Ior| match ior {
            Ior::Constant(value) => *value,
            _ => panic!("tests use constants"),
        };
        let mut media = vec![("world".to_owned(), index_of(&description.world.ior))];
        media.extend(description.media.iter().map(|m| (m.name.clone(), index_of(&m.ior))));
        let medium_named = |name: &str| media.iter().position(|m| m.0 == name).unwrap();
        // The program rounds vertices to f32 about this point: what it is to be right about is the rounded surface.
        let origin = compile(description, None).expect("the scene is fine").geometry.origin;
        let body = |shape, transform, medium, priority| body(shape, transform, medium, priority, origin);
        let bodies: Vec<Body> = (description.objects.iter())
            .map(|object| {
                let medium = object.refractor().map(|refractor| medium_named(&refractor.medium));
                let priority = object.refractor().map_or(0, |refractor| refractor.priority);
                body(&object.shape, &object.transform, medium, priority)
            })
            .collect();
        let (size, together, margin) = (0.0, 0.0, 0.0);
        let (top, coincident) = (is_above as fn(Candidate, Candidate) -> bool, Cell::new(0));
        let (origin, grazing, has_holes) = (DVec3::ZERO, 0.02, false);
        Self { bodies, origin, media, size, together, margin, grazing, top, coincident, has_holes }.measured()
    }

    /// The same, computed relative to a point of the scene, so that what is far from zero for its size keeps its digits. Meshes have been
    /// rounded by then: those of [`Truth::with_solids`] are not.
    pub fn relative_to(mut self, origin: DVec3) -> Self {
        for body in &mut self.bodies {
            match &mut body.surface {
                Surface::Ball { center, .. } => *center -= origin,
                Surface::Solids(solids) => solids.iter_mut().for_each(|solid| solid.shift(-origin)),
            }
            (body.min, body.max) = (body.min - origin, body.max - origin);
        }
        Self { origin: self.origin + origin, ..self }
    }

    /// With distances that fit the bodies' size.
    fn measured(self) -> Self {
        let (min, max) = self.bounds();
        let size = (max - min).max_element();
        Self { size, together: 1e-6 * size, margin: 1e-5 * size, ..self }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let min = self.bodies.iter().fold(DVec3::INFINITY, |m, b| m.min(b.min));
        let max = self.bodies.iter().fold(DVec3::NEG_INFINITY, |m, b| m.max(b.max));
        (min, max)
    }

    /// The same where the refractor of that index is the union of these solids of that `volume`, given relative to the truth's own origin: for
    /// meshes whose parts their maker knows.
    pub fn with_solids(mut self, refractor: usize, solids: Vec<Solid>, volume: f64, has_holes: bool) -> Self {
        let body = &mut self.bodies[refractor];
        body.min = solids.iter().fold(DVec3::INFINITY, |m, s| m.min(s.shell.min));
        body.max = solids.iter().fold(DVec3::NEG_INFINITY, |m, s| m.max(s.shell.max));
        body.surface = Surface::Solids(solids);
        body.volume = volume;
        self.has_holes |= has_holes;
        self.measured()
    }

    /// The refractors that contain a point relative to the origin, by index.
    pub fn containers(&self, point: DVec3) -> Vec<usize> {
        let contains = |body: &Body| match &body.surface {
            Surface::Ball { center, radius } => point.distance(*center) < *radius,
            Surface::Solids(solids) => solids.iter().any(|solid| solid.contains(point)),
        };
        (0..self.bodies.len()).filter(|&b| self.bodies[b].medium.is_some() && contains(&self.bodies[b])).collect()
    }

    fn medium_index_at(&self, point: DVec3) -> usize {
        let candidate = |index: usize| {
            let body = &self.bodies[index];
            Candidate { index, priority: body.priority, volume: body.volume }
        };
        let mut best: Option<Candidate> = None;
        for index in self.containers(point) {
            let new = candidate(index);
            if best.is_none_or(|best| (self.top)(best, new)) {
                best = Some(new);
            }
        }
        best.and_then(|best| self.bodies[best.index].medium).unwrap_or(0)
    }

    /// Name of the medium at a point relative to the origin.
    pub fn medium_at(&self, point: DVec3) -> &str {
        &self.media[self.medium_index_at(point)].0
    }

    /// The same with another rule for overlaps.
    pub fn with_top(self, top: fn(Candidate, Candidate) -> bool) -> Self {
        Self { top, ..self }
    }

    /// The media along a straight line, each different from the one before, up to the first opaque thing. `None` where the line runs along a
    /// surface.
    pub fn straight_through(&self, ray: &Ray) -> Option<Vec<String>> {
        let mut meetings = self.meetings(ray, 0.0);
        if let Some(end) = meetings.iter().position(|m| self.bodies[m.body].medium.is_none()) {
            meetings.truncate(end + 1);
        }
        let mut names: Vec<String> = Vec::new();
        let mut start = 0.0;
        let mut stops: Vec<f64> = meetings.iter().map(|m| m.t).collect();
        if meetings.last().is_none_or(|m| self.bodies[m.body].medium.is_some()) {
            stops.push(stops.last().copied().unwrap_or(0.0) + self.size);
        }
        for stop in stops {
            if stop - start > self.together {
                let middle = ray.at(0.5 * (start + stop));
                if self.clearance(middle, &[]) < self.together {
                    return None;
                }
                let name = self.medium_at(middle);
                if names.last().is_none_or(|last| last != name) {
                    names.push(name.to_owned());
                }
            }
            start = stop;
        }
        Some(names)
    }

    /// Every meeting of a ray with anything, beyond `t_min`, nearest first.
    fn meetings(&self, ray: &Ray, t_min: f64) -> Vec<Meeting> {
        let mut meetings = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            match &body.surface {
                Surface::Ball { center, radius } => {
                    let to_center = *center - ray.origin;
                    let along = to_center.dot(ray.direction);
                    let off = (to_center - ray.direction * along).length_squared();
                    let half_chord = (radius * radius - off).sqrt();
                    for t in [along - half_chord, along + half_chord] {
                        if t > t_min {
                            let normal = (ray.at(t) - *center) / *radius;
                            meetings.push(Meeting { t, normal, edge: f64::INFINITY, body: index, shell: 0 });
                        }
                    }
                }
                Surface::Solids(solids) => {
                    for (number, shell) in solids.iter().flat_map(Solid::shells).enumerate() {
                        if !line_meets_box(ray, shell.min, shell.max) {
                            continue;
                        }
                        for &triangle in &shell.triangles {
                            if let Some(meeting) = meet_triangle(ray, triangle).filter(|m| m.t > t_min) {
                                meetings.push(Meeting { body: index, shell: number, ..meeting });
                            }
                        }
                    }
                }
            }
        }
        meetings.sort_by(|a, b| a.t.total_cmp(&b.t));
        meetings
    }

    /// Distance from a point to the nearest surface but those of the shells `except`, which are given by body and number.
    fn clearance(&self, point: DVec3, except: &[(usize, usize)]) -> f64 {
        let mut nearest = f64::INFINITY;
        for (index, body) in self.bodies.iter().enumerate() {
            match &body.surface {
                Surface::Ball { center, radius } if !except.contains(&(index, 0)) => {
                    nearest = nearest.min((point.distance(*center) - radius).abs());
                }
                Surface::Ball { .. } => {}
                Surface::Solids(solids) => {
                    let shells = solids.iter().flat_map(Solid::shells).enumerate();
                    for (_, shell) in shells.filter(|(number, _)| !except.contains(&(index, *number))) {
                        let outside = (shell.min - point).max(point - shell.max).max(DVec3::ZERO).length();
                        if outside < nearest && outside <= 10.0 * self.margin {
                            let distances = shell.triangles.iter().map(|t| distance_to_triangle(*t, point));
                            nearest = distances.fold(nearest, f64::min);
                        }
                    }
                }
            }
        }
        nearest
    }

    /// Whether the same refractors contain all of a piece of a ray, with no doubt: a shell with holes has none where its winding number
    /// is far from ½.
    fn is_steady(&self, ray: &Ray, from: f64, to: f64) -> bool {
        const STEPS: u32 = 8;
        let (first, last) = (from + 0.5 * self.margin, to - 0.5 * self.margin);
        let at = |step: u32| ray.at(first + (last - first) * f64::from(step) / f64::from(STEPS));
        let there = self.containers(at(0));
        (0..=STEPS).map(at).all(|point| self.is_clear(point) && self.containers(point) == there)
    }

    /// Whether every winding number around a point is far from ½.
    fn is_clear(&self, point: DVec3) -> bool {
        const CLEAR: f64 = 0.2;
        self.bodies.iter().all(|body| match &body.surface {
            Surface::Ball { .. } => true,
            Surface::Solids(solids) => {
                solids.iter().flat_map(Solid::shells).all(|shell| (shell.winding(point) - 0.5).abs() > CLEAR)
            }
        })
    }

    /// The next interface or opaque surface on a ray that starts on a surface, or anywhere.
    fn next(&self, ray: &Ray) -> Found {
        let meetings = self.meetings(ray, self.together);
        let mut before = None;
        let mut first = 0;
        while first < meetings.len() {
            let mut last = first;
            while last + 1 < meetings.len() && meetings[last + 1].t - meetings[last].t <= self.together {
                last += 1;
            }
            let group = &meetings[first..=last];
            let nearest = &group[0];
            let position = ray.at(nearest.t);
            let here: Vec<(usize, usize)> = group.iter().map(|m| (m.body, m.shell)).collect();
            let is_clear =
                group.iter().all(|m| m.normal.dot(ray.direction).abs() >= self.grazing && m.edge >= self.margin)
                    && self.clearance(position, &here) >= self.margin;
            let previous = if first == 0 { 0.0 } else { meetings[first - 1].t };
            let until = meetings.get(last + 1).map_or(group[group.len() - 1].t + self.size, |m| m.t);
            if !is_clear || nearest.t - previous < self.margin || until - group[group.len() - 1].t < self.margin {
                return Found::IllConditioned;
            }
            let end = group[group.len() - 1].t;
            if self.has_holes && !(self.is_steady(ray, previous, nearest.t) && self.is_steady(ray, end, until)) {
                return Found::IllConditioned;
            }
            let is_coincident = here.iter().any(|&shell| shell != here[0]);
            self.coincident.set(self.coincident.get() + usize::from(is_coincident));
            let from = *before.get_or_insert_with(|| self.medium_index_at(ray.at(0.5 * (previous + nearest.t))));
            if group.iter().any(|m| self.bodies[m.body].medium.is_none()) {
                return Found::Next(Next { position, normal: nearest.normal, from, to: None });
            }
            let to = self.medium_index_at(ray.at(0.5 * (group[group.len() - 1].t + until)));
            if from != to {
                return Found::Next(Next { position, normal: nearest.normal, from, to: Some(to) });
            }
            first = last + 1;
        }
        Found::Nothing
    }

    /// Goes along a traced path and checks every vertex: that it is the next place at which the medium changes, which media it names, what
    /// happened there and where the path went on. Stops where the path is badly conditioned. Returns the number of vertices checked, the
    /// end of the path counting as one.
    ///
    /// # Errors
    /// The first difference, in words.
    pub fn check(&self, ray: &Ray, path: &TracedPath) -> Result<usize, String> {
        // Faces that coincide but for rounding are met up to this far apart at a grazing angle, and any of them may stand for all.
        let tolerance = 4e-6 * self.size;
        let mut ray = Ray::new(ray.origin - self.origin, ray.direction.normalize());
        if self.clearance(ray.origin, &[]) < self.margin || (self.has_holes && !self.is_clear(ray.origin)) {
            return Ok(0);
        }
        let here = self.medium_at(ray.origin);
        let local = |position: [f64; 3]| DVec3::from(position) - self.origin;
        if path.camera_medium != here {
            return Err(format!("it starts in {}, not in {here}", path.camera_medium));
        }
        // Surfaces with one medium on both sides are none.
        let vertices: Vec<_> =
            path.vertices.iter().filter(|v| v.event != VertexEvent::Skip || v.from != v.to).collect();
        for (k, vertex) in vertices.iter().enumerate() {
            let position = local(vertex.position);
            let next = match self.next(&ray) {
                Found::IllConditioned => return Ok(k),
                Found::Nothing => return Err(format!("vertex {k} at {position}: nothing is there")),
                Found::Next(next) => next,
            };
            if next.position.distance(position) > tolerance {
                return Err(format!("vertex {k} at {position}: the next one is at {}", next.position));
            }
            let Some(to) = next.to else {
                let is_opaque = vertex.refractor.is_none();
                return if is_opaque { Ok(k + 1) } else { Err(format!("vertex {k} at {position}: it is opaque")) };
            };
            let ((from, ior_from), (to, ior_to)) = (&self.media[next.from], &self.media[to]);
            let seen = (vertex.from.as_deref().unwrap_or("nothing"), vertex.to.as_deref().unwrap_or("nothing"));
            if seen != (from, to) {
                return Err(format!("vertex {k} at {position}: {} to {}, not {from} to {to}", seen.0, seen.1));
            }
            let onward = match vertices.get(k + 1) {
                Some(next) => (local(next.position) - position).normalize(),
                None if path.escaped => DVec3::from(path.final_direction),
                // The cap on depth.
                None => return Ok(k + 1),
            };
            let expected = direction_after(vertex.event, ray.direction, next.normal, ior_to / ior_from)
                .ok_or_else(|| format!("vertex {k} at {position}: {:?} cannot be", vertex.event))?;
            if expected.distance(onward) > 1e-5 {
                return Err(format!("vertex {k} at {position}: it goes on along {onward}, not along {expected}"));
            }
            // Along the path's own direction, which has just been checked: each vertex would multiply the rounding of those before it. Where
            // the next one is too near to tell that direction, along the expected one.
            let is_known = vertices.get(k + 1).is_none_or(|v| local(v.position).distance(position) > 1e-6 * self.size);
            ray = Ray::new(position, if is_known { onward } else { expected });
        }
        match self.next(&ray) {
            Found::Nothing if path.escaped => Ok(vertices.len() + 1),
            Found::Next(next) if path.escaped => Err(format!("it misses what is at {}", next.position)),
            _ => Ok(vertices.len()),
        }
    }
}

/// Snell's law and the law of reflection. `None` where the event is impossible. `ratio` is n_to/n_from.
fn direction_after(event: VertexEvent, d: DVec3, outward: DVec3, ratio: f64) -> Option<DVec3> {
    let n = if d.dot(outward) < 0.0 { outward } else { -outward };
    let cos = -d.dot(n);
    let sin_squared = (1.0 - cos * cos) / (ratio * ratio);
    let is_total = sin_squared > 1.0;
    match event {
        VertexEvent::Transmit if sin_squared < 1.0 + 1e-9 => {
            Some(((d + n * cos) / ratio - n * (1.0 - sin_squared).max(0.0).sqrt()).normalize())
        }
        VertexEvent::Skip if ratio == 1.0 => Some(d),
        VertexEvent::Reflect => Some((d + n * (2.0 * cos)).normalize()),
        VertexEvent::TotalReflection if is_total || sin_squared > 1.0 - 1e-9 => Some((d + n * (2.0 * cos)).normalize()),
        _ => None,
    }
}

fn body(shape: &Shape, transform: &Transform, medium: Option<usize>, priority: i32, origin: DVec3) -> Body {
    let matrix = transform.matrix();
    if let Shape::Sphere { center, radius } = shape {
        let (center, radius) = (matrix.transform_point3(*center), radius * transform.scale.x.abs());
        let volume = 4.0 / 3.0 * PI * radius.powi(3);
        let surface = Surface::Ball { center, radius };
        return Body { surface, medium, priority, volume, min: center - radius, max: center + radius };
    }
    let mesh = tessellate(shape).unwrap().unwrap();
    let is_mirrored = matrix.matrix3.determinant() < 0.0;
    let rounded = |p: DVec3| (p - origin).as_vec3().as_dvec3() + origin;
    let corner = |i: u32| rounded(matrix.transform_point3(mesh.positions[i as usize]));
    let triangles: Vec<[DVec3; 3]> =
        (mesh.triangles.iter()).map(|&[a, b, c]| if is_mirrored { [a, c, b] } else { [a, b, c] }.map(corner)).collect();
    let shell = Shell::new(triangles);
    let (volume, min, max) = (shell.volume().abs(), shell.min, shell.max);
    let surface = Surface::Solids(vec![Solid { shell, cavities: Vec::new() }]);
    Body { surface, medium, priority, volume, min, max }
}

/// Times that the triangles enclose `point`: the sum of their solid angles over 4π (Van Oosterom and Strackee 1983).
pub fn winding_number(triangles: &[[DVec3; 3]], point: DVec3) -> f64 {
    let solid_angle = |t: &[DVec3; 3]| {
        let [a, b, c] = t.map(|p| p - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(denominator)
    };
    triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * PI)
}

/// Whether the whole line passes a box, or nearly so.
fn line_meets_box(ray: &Ray, min: DVec3, max: DVec3) -> bool {
    let radius = (max - min).length() / 2.0 * 1.001;
    let to_center = (min + max) / 2.0 - ray.origin;
    to_center.cross(ray.direction).length() <= radius
}

/// Möller and Trumbore 1997. Edges are included with some room, so that no ray slips between two triangles; meeting both does no harm.
fn meet_triangle(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<Meeting> {
    let (ab, ac) = (b - a, c - a);
    let p = ray.direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = ray.origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(ab);
    let v = ray.direction.dot(q) / determinant;
    let w = 1.0 - u - v;
    if u.min(v).min(w) < -1e-12 {
        return None;
    }
    let area_vector = ab.cross(ac);
    let double_area = area_vector.length();
    // Heights over the three edges.
    let edge =
        (w * double_area / (c - b).length()).min(u * double_area / ac.length()).min(v * double_area / ab.length());
    Some(Meeting { t: ac.dot(q) / determinant, normal: area_vector / double_area, edge, body: 0, shell: 0 })
}

/// The least of the distances to the plane, where the foot lies in the triangle, and to the three edges.
pub fn distance_to_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let to_segment = |a: DVec3, b: DVec3| {
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + (b - a) * along)
    };
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_over = [(a, b), (b, c), (c, a)].into_iter().all(|(a, b)| (b - a).cross(p - a).dot(normal) >= 0.0);
    let to_plane = if is_over && normal != DVec3::ZERO { (p - a).dot(normal).abs() } else { f64::INFINITY };
    to_plane.min(to_segment(a, b)).min(to_segment(b, c)).min(to_segment(c, a))
}

/// What came of following many rays.
#[derive(Debug, Default)]
pub struct Survey {
    /// Vertices and ends of paths that were compared.
    pub checked: usize,
    /// Surfaces on the way that coincided with another body's.
    pub coincident: usize,
    pub faults: Vec<String>,
    /// Of paths that were well-conditioned from end to end.
    pub events: u64,
}

/// Traces rays in a mode and compares every vertex with the truth.
pub fn survey(scene: &Prepared, truth: &Truth, mode: Mode, rays: &[Ray]) -> Survey {
    let mut survey = Survey::default();
    truth.coincident.set(0);
    for (index, ray) in rays.iter().enumerate() {
        let follow = if index % 3 == 0 { Follow::Transmit } else { Follow::Sample };
        let path = trace(scene, mode, *ray, follow, index as u64, Some(14));
        match truth.check(ray, &path) {
            Ok(checked) => {
                survey.checked += checked;
                let vertices = path.vertices.iter().filter(|v| v.event != VertexEvent::Skip || v.from != v.to).count();
                // A path that was not followed to its end may have met what is badly conditioned.
                let is_complete = checked == vertices + usize::from(path.escaped);
                if is_complete && path.events.total() > 0 {
                    survey.events += 1;
                    survey.faults.push(format!("ray {index}, {mode}: {:?}", path.events));
                }
            }
            Err(fault) => {
                survey.faults.push(format!("ray {index} from {} along {}, {mode}: {fault}", ray.origin, ray.direction))
            }
        }
    }
    survey.coincident = truth.coincident.get();
    survey
}

/// Rays into the box from `min` to `max` from outside, and rays that start in it, by turns.
pub fn rays(count: usize, seed: u64, min: DVec3, max: DVec3) -> Vec<Ray> {
    let mut numbers = Numbers(seed);
    let (center, radius) = ((min + max) / 2.0, (max - min).length() / 2.0);
    (0..count)
        .map(|k| {
            let point = numbers.point(min, max);
            let direction = numbers.direction();
            if k % 2 == 0 {
                let origin = center + direction * (1.5 * radius);
                Ray::new(origin, (point - origin).normalize())
            } else {
                Ray::new(point, direction)
            }
        })
        .collect()
}

impl Truth {
    /// Rays into and within the bounding box of everything.
    pub fn rays(&self, count: usize, seed: u64) -> Vec<Ray> {
        let (min, max) = self.bounds();
        rays(count, seed, min + self.origin, max + self.origin)
    }
}

/// The media that a path goes through, each different from the one before. Stretches no longer than `together`, between faces that meet
/// in an edge or a vertex, do not count.
///
/// # Errors
/// When the path leaves another medium than the one it was in: all its vertices.
pub fn media_along(path: &TracedPath, together: f64) -> Result<Vec<String>, String> {
    let mut names = vec![path.camera_medium.clone()];
    let mut last = None;
    for vertex in path.vertices.iter().filter(|v| v.from != v.to) {
        let (from, to) = (vertex.from.as_ref().unwrap(), vertex.to.as_ref().unwrap());
        let position = DVec3::from(vertex.position);
        if names.last() != Some(from) {
            let vertices = path.vertices.iter().map(|v| format!("{:?} {:?} to {:?}", v.position, v.from, v.to));
            return Err(format!("{names:?}: {:#?}", vertices.collect::<Vec<_>>()));
        }
        if last.is_some_and(|last| position.distance(last) <= together) {
            names.pop();
        }
        if names.last() != Some(to) {
            names.push(to.clone());
        }
        last = Some(position);
    }
    Ok(names)
}
