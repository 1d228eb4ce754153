//! Closed parts of meshes, each known exactly and each also as an exporter would write it: with the vertices of seams and poles repeated, a
//! few roundings off.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3};
use iorect::scene::description::Shape;
use iorect::scene::shapes::tessellate;

use super::Numbers;

/// A closed surface that looks outward.
#[derive(Debug, Clone)]
pub struct Part {
    pub name: &'static str,
    /// Where the vertices are.
    pub points: Vec<DVec3>,
    /// Vertices as written: the point that each stands for, and its coordinates.
    pub written: Vec<(u32, DVec3)>,
    /// Triangles of written vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Outlines of the flat faces of a polyhedron, counter-clockwise seen from outside, as indices of points; else none.
    pub polygons: Vec<Vec<u32>>,
}

impl Part {
    /// The triangles by the points that they stand for.
    pub fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles.iter().map(|t| t.map(|i| self.points[self.written[i as usize].0 as usize]))
    }

    pub fn moved(mut self, by: &DAffine3) -> Self {
        self.points.iter_mut().for_each(|p| *p = by.transform_point3(*p));
        self.written.iter_mut().for_each(|w| w.1 = by.transform_point3(w.1));
        if by.matrix3.determinant() < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            self.polygons.iter_mut().for_each(|p| p.reverse());
        }
        self
    }

    pub fn middle(&self) -> DVec3 {
        self.points.iter().sum::<DVec3>() / self.points.len() as f64
    }

    pub fn radius(&self) -> f64 {
        let middle = self.middle();
        self.points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max)
    }

    /// Outward unit normal of a flat face.
    pub fn normal(&self, polygon: usize) -> DVec3 {
        let [a, b, c] = [0, 1, 2].map(|k| self.points[self.polygons[polygon][k] as usize]);
        (b - a).cross(c - a).normalize()
    }

    /// The corners of a flat face.
    pub fn outline(&self, polygon: usize) -> Vec<DVec3> {
        self.polygons[polygon].iter().map(|&i| self.points[i as usize]).collect()
    }

    /// A polyhedron whose flat faces are convex, each cut into a fan of triangles around one of its corners.
    pub fn polyhedron(
        numbers: &mut Numbers,
        name: &'static str,
        points: Vec<DVec3>,
        mut polygons: Vec<Vec<u32>>,
    ) -> Self {
        let mut triangles = Vec::new();
        for polygon in &polygons {
            let first = numbers.index(polygon.len());
            let at = |k: usize| polygon[(first + k) % polygon.len()];
            triangles.extend((1..polygon.len() - 1).map(|k| [at(0), at(k), at(k + 1)]));
        }
        let corner = |i: u32| points[i as usize] - points[0];
        let volume: f64 = triangles.iter().map(|t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2])))).sum();
        if volume < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
            polygons.iter_mut().for_each(|p| p.reverse());
        }
        let written = points.iter().enumerate().map(|(i, p)| (i as u32, *p)).collect();
        Self { name, points, written, triangles, polygons }
    }

    /// A prism over an outline, between it and the same outline moved `by`.
    pub fn prism_over(numbers: &mut Numbers, outline: &[DVec3], by: DVec3) -> Self {
        let n = outline.len() as u32;
        let points = outline.iter().copied().chain(outline.iter().map(|p| *p + by)).collect();
        let mut polygons = vec![(0..n).rev().collect::<Vec<u32>>(), (n..2 * n).collect()];
        polygons.extend((0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]));
        let name = if n == 4 { "cube" } else { "prism" };
        Self::polyhedron(numbers, name, points, polygons)
    }

    /// A pyramid over an outline: of a triangle, a tetrahedron.
    pub fn pyramid_over(numbers: &mut Numbers, outline: &[DVec3], tip: DVec3) -> Self {
        let n = outline.len() as u32;
        let points = outline.iter().copied().chain([tip]).collect();
        let mut polygons = vec![(0..n).rev().collect::<Vec<u32>>()];
        polygons.extend((0..n).map(|k| vec![k, (k + 1) % n, n]));
        let name = if n == 3 { "tetrahedron" } else { "pyramid" };
        Self::polyhedron(numbers, name, points, polygons)
    }
}

/// A cube, a tetrahedron or a prism of random measures, about as large as a ball of `radius` around the origin.
pub fn polyhedron(numbers: &mut Numbers, radius: f64) -> Part {
    // Rounded to eighths, so that some of them have exact coordinates.
    let mut length = || (1 + numbers.index(8)) as f64 / 8.0 * 0.6 * radius + 0.2 * radius;
    let (x, y, z) = (length(), length(), length());
    let at = DVec3::new;
    match numbers.index(3) {
        0 => {
            let outline = [at(-x, -y, -z), at(x, -y, -z), at(x, y, -z), at(-x, y, -z)];
            Part::prism_over(numbers, &outline, DVec3::Z * 2.0 * z)
        }
        1 => {
            let outline = [at(x, x, x), at(x, -x, -x), at(-x, x, -x)].map(|p| p * at(1.0, y / x, z / x));
            Part::pyramid_over(numbers, &outline, at(-x, -y, z))
        }
        _ => {
            let outline = [at(-x, -z, -y), at(x, -z, -y), at(0.25 * x, -z, y)];
            Part::prism_over(numbers, &outline, DVec3::Y * 2.0 * z)
        }
    }
}

/// A surface over a grid of columns and rows, whose last column repeats the first, and whose last row does too, or whose first and last rows
/// are poles, each written once per column. `at` takes angles and places beyond the end as an exporter's loop would.
fn over_grid(name: &'static str, columns: u32, rows: u32, closes: bool, at: impl Fn(u32, u32) -> DVec3) -> Part {
    let mut points = Vec::new();
    let mut written = Vec::new();
    let mut place = vec![0; ((columns + 1) * (rows + 1)) as usize];
    for row in 0..=rows {
        for column in 0..=columns {
            let is_pole = !closes && (row == 0 || row == rows);
            let first = [if is_pole { 0 } else { column % columns }, if closes { row % rows } else { row }];
            let index = (row * (columns + 1) + column) as usize;
            place[index] = if first == [column, row] {
                points.push(at(column, row));
                points.len() as u32 - 1
            } else {
                place[(first[1] * (columns + 1) + first[0]) as usize]
            };
            written.push((place[index], at(column, row)));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let vertex = |c: u32, r: u32| r * (columns + 1) + c;
            let [a, b] = [vertex(column, row), vertex(column + 1, row)];
            let [c, d] = [vertex(column + 1, row + 1), vertex(column, row + 1)];
            for triangle in [[a, b, c], [a, c, d]] {
                let [p, q, r] = triangle.map(|v| written[v as usize].0);
                if p != q && q != r && r != p {
                    triangles.push(triangle);
                }
            }
        }
    }
    let mut part = Part { name, points, written, triangles, polygons: Vec::new() };
    let volume: f64 = part.corners().map(|[a, b, c]| a.dot(b.cross(c))).sum();
    if volume < 0.0 {
        part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    part
}

/// An outline (r, y) from the axis to the axis, revolved about y.
fn revolved(name: &'static str, outline: &[(f64, f64)], columns: u32) -> Part {
    let rows = outline.len() as u32 - 1;
    over_grid(name, columns, rows, false, |column, row| {
        let (sin, cos) = (TAU * f64::from(column) / f64::from(columns)).sin_cos();
        let (r, y) = outline[row as usize];
        DVec3::new(r * cos, y, r * sin)
    })
}

/// A cylinder, cone, capsule, lathe, ball, torus or knot with repeated seams, or an icosphere without, about as large as a ball of `radius`
/// around the origin.
pub fn round(numbers: &mut Numbers, radius: f64) -> Part {
    let columns = 8 + numbers.index(9) as u32;
    let slim = numbers.between(0.3, 0.8);
    match numbers.index(8) {
        0 => cylinder(numbers, radius),
        1 => revolved("cone", &[(0.0, -radius), (slim * radius, -radius), (0.0, radius)], columns),
        2 => {
            let (r, half) = (0.5 * slim * radius, radius * (1.0 - 0.5 * slim));
            let point = |k: u32| {
                let (sin, cos) = (f64::from(k) * PI / 10.0).sin_cos();
                (r * sin, if k < 5 { -half } else { half } - r * cos)
            };
            let outline: Vec<(f64, f64)> = (0..=10).map(point).collect();
            revolved("capsule", &outline, columns)
        }
        3 => {
            let (a, b) = (slim * radius, numbers.between(0.1, 0.3) * radius);
            let outline = [(0.0, -radius), (a, -radius), (a, -0.6 * radius), (b, -0.4 * radius), (b, 0.2 * radius)];
            let rest = [(a, 0.7 * radius), (0.7 * a, radius), (0.0, radius)];
            revolved("lathe", &[&outline[..], &rest[..]].concat(), columns)
        }
        4 => {
            let rows = 6 + numbers.index(5) as u32;
            let outline: Vec<(f64, f64)> = (0..=rows)
                .map(|k| (PI * f64::from(k) / f64::from(rows)).sin_cos())
                .map(|(sin, cos)| (radius * sin, -radius * cos))
                .collect();
            revolved("ball", &outline, columns)
        }
        5 => {
            let minor = numbers.between(0.15, 0.4) * radius;
            torus(radius - minor, minor, columns + 4, 7)
        }
        6 => knot(radius),
        _ => icosphere(radius, 1 + numbers.index(2) as u32),
    }
}

/// With flat ends at ±its height.
pub fn cylinder(numbers: &mut Numbers, radius: f64) -> Part {
    let (r, y) = (numbers.between(0.3, 0.8) * radius, numbers.between(0.3, 0.9) * radius);
    revolved("cylinder", &[(0.0, -y), (r, -y), (r, y), (0.0, y)], 8 + numbers.index(9) as u32)
}

pub fn torus(major: f64, minor: f64, columns: u32, rows: u32) -> Part {
    over_grid("torus", columns, rows, true, |column, row| {
        let (sin_u, cos_u) = (TAU * f64::from(column) / f64::from(columns)).sin_cos();
        let (sin_v, cos_v) = (TAU * f64::from(row) / f64::from(rows)).sin_cos();
        let r = major + minor * cos_v;
        DVec3::new(r * cos_u, minor * sin_v, r * sin_u)
    })
}

/// A tube around a trefoil on a torus.
pub fn knot(radius: f64) -> Part {
    let (columns, rows) = (48, 6);
    let tube = 0.1 * radius;
    let (major, minor) = (0.6 * radius, 0.3 * radius);
    let middle = |u: f64| {
        let r = major + minor * (3.0 * u).cos();
        DVec3::new(r * (2.0 * u).cos(), minor * (3.0 * u).sin(), r * (2.0 * u).sin())
    };
    over_grid("knot", columns, rows, true, |column, row| {
        let u = TAU * f64::from(column) / f64::from(columns);
        let v = TAU * f64::from(row) / f64::from(rows);
        let tangent = (middle(u + 1e-4) - middle(u - 1e-4)).normalize();
        // Away from the circle that the torus runs around: it never points along the tube.
        let ring = DVec3::new((2.0 * u).cos(), 0.0, (2.0 * u).sin()) * major;
        let normal = (middle(u) - ring).reject_from(tangent).normalize();
        let (sin, cos) = v.sin_cos();
        middle(u) + (normal * cos + tangent.cross(normal) * sin) * tube
    })
}

pub fn icosphere(radius: f64, subdivisions: u32) -> Part {
    let mesh = tessellate(&Shape::Icosphere { center: DVec3::ZERO, radius, subdivisions }).unwrap().unwrap();
    let written = mesh.positions.iter().enumerate().map(|(i, p)| (i as u32, *p)).collect();
    let (points, triangles) = (mesh.positions, mesh.triangles);
    Part { name: "icosphere", points, written, triangles, polygons: Vec::new() }
}

pub fn any(numbers: &mut Numbers, radius: f64) -> Part {
    if numbers.index(3) == 0 { polyhedron(numbers, radius) } else { round(numbers, radius) }
}
