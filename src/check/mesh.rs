//! Surfaces that are not what an enclosure should be, and what was made of them.

use super::{Problem, Severity};
use crate::geometry::topology::{Finding, FindingKind};
use crate::geometry::{Enclosure, Topology};
use crate::render::Prepared;
use crate::scene::description::{Refractor, Shape};

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let description = &*prepared.description;
    let mut problems = Vec::new();
    // Refractors are the first objects.
    for (refractor, object) in description.refractors.iter().zip(&prepared.world.objects) {
        match (&refractor.shape, &object.topology) {
            (Shape::Quad { .. }, _) => problems.push(Problem::warning(
                &refractor.name,
                "open_mesh",
                "a quad encloses nothing, so a refractor of that shape has no inside: what lies behind it counts as such, as far as the \
                 next surface",
            )),
            (_, Some(topology)) => {
                problems.extend(topology.findings.iter().map(|finding| problem(refractor, topology, finding)));
            }
            _ => {}
        }
    }
    problems
}

/// What is to be said of a finding.
fn problem(refractor: &Refractor, topology: &Topology, finding: &Finding) -> Problem {
    let count = finding.count;
    let of = |one: &str, many: &str| if count == 1 { format!("1 {one}") } else { format!("{count} {many}") };
    let faces = of("face", "faces");
    let components = of("separate part", "separate parts");
    let center = refractor.transform.matrix().transform_point3(finding.center);
    let [x, y, z] = center.to_array();
    let near = format!("near [{x:.4}, {y:.4}, {z:.4}]");
    let (severity, message) = match finding.kind {
        FindingKind::DegenerateTriangles => {
            (Severity::Advice, format!("{faces} of the mesh, {near}, have two corners at one place and were left out"))
        }
        FindingKind::DuplicateTriangles => {
            (Severity::Advice, format!("{faces} of the mesh, {near}, repeat others and were left out: remove them"))
        }
        FindingKind::DoubleFaces => (
            Severity::Warning,
            format!(
                "{} of faces, {near}, lie on each other and look opposite ways. {}",
                of("pair", "pairs"),
                if count as usize == topology.component_of_face.len() {
                    "The whole mesh is so: one face of each pair was kept. Export it one-sided"
                } else {
                    "They enclose nothing and were left out: remove them"
                }
            ),
        ),
        FindingKind::MixedOrientation => (
            Severity::Warning,
            format!(
                "{faces} of the mesh, {near}, looked another way than their neighbours and were turned over: make them agree"
            ),
        ),
        FindingKind::OneSided => (
            Severity::Warning,
            format!(
                "{components} of the mesh, {near}, are one-sided, like a Möbius strip: their faces cannot all look outward, and what is \
                 inside is a guess"
            ),
        ),
        FindingKind::InsideOut => (
            Severity::Warning,
            if count == u64::from(topology.components) {
                "the faces of the mesh looked inward and were turned over: turn them in the model, too".to_owned()
            } else {
                format!(
                    "{components} of the mesh, {near}, looked inward though in nothing else, and were turned over: turn them in the model"
                )
            },
        ),
        FindingKind::OpenMesh => open(topology, count, &near),
        FindingKind::NonManifold => (
            Severity::Warning,
            format!(
                "{} of the mesh, the first {near}, are shared by more than two faces, so it is not plain which of them belong together: \
                 separate the parts, or remove inner walls",
                of("edge", "edges")
            ),
        ),
        FindingKind::SelfIntersection => (
            Severity::Warning,
            format!(
                "the mesh crosses itself in at least {}, the first {near}: its parts count as one volume. Unite them in the model if \
                 their crossing should not be seen from inside",
                of("pair of faces", "pairs of faces")
            ),
        ),
        FindingKind::Cavity => (
            Severity::Advice,
            format!(
                "{components} of the mesh, {near}, look inward and lie in another: a cavity, which holds what surrounds the object. Turn its \
                 faces over if it should be filled"
            ),
        ),
        FindingKind::NestedComponents => (
            Severity::Warning,
            format!(
                "{components} of the mesh, {near}, lie in another that looks the same way: there is the same medium on both sides, and \
                 they cannot be seen. For a cavity turn their faces over, for another medium make them an object of their own"
            ),
        ),
        FindingKind::ZeroVolume if topology.component_of_face.is_empty() => (
            Severity::Warning,
            "after its repair nothing is left of the mesh: it encloses nothing and cannot be seen".to_owned(),
        ),
        FindingKind::ZeroVolume => {
            (Severity::Warning, format!("the mesh, {near}, is closed but encloses nothing: it has no thickness"))
        }
    };
    let problem = Problem { severity, ..Problem::warning(&refractor.name, finding.kind.word(), message) };
    // Something of no size is everywhere on the object.
    let radius = finding.radius * refractor.transform.scale.abs().max_element();
    if radius > 0.0 { problem.at(center, radius) } else { problem }
}

/// A boundary is worth as many words as it is wide.
fn open(topology: &Topology, count: u64, near: &str) -> (Severity, String) {
    let edges = if count == 1 { "1 of its edges is".to_owned() } else { format!("{count} of its edges are") };
    let start = format!("the mesh is not closed: {edges} not shared by two faces that look the same way");
    let percent = topology.gap * 100.0;
    match topology.enclosure {
        Enclosure::Closed | Enclosure::Union => (
            Severity::Advice,
            format!("{start}, the first {near}. There is no gap, only vertices that do not match: merge them"),
        ),
        Enclosure::Holed => (
            Severity::Warning,
            format!(
                "{start}. The widest hole is {near}; all together are {percent:.2} % of its area. What is inside is asked as if they \
                 were filled: close them"
            ),
        ),
        Enclosure::Sheet => (
            Severity::Warning,
            format!(
                "{start}, {near}. It takes {percent:.0} % of its area to close it, so it counts as a sheet: what lies behind its faces is \
                 inside, as far as the next opaque surface. Close it if it should enclose something"
            ),
        ),
    }
}
