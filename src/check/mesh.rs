//! Surfaces that are not what an enclosure should be, and what was made of them.

use super::confidence::{Doubt, Doubts};
use super::rims::Rims;
use super::{Problem, Severity, Spot, names, nested};
use crate::geometry::topology::{Finding, FindingKind};
use crate::geometry::{Enclosure, Topology};
use crate::scene::ObjectId;
use crate::scene::description::{Object, Shape};
use crate::tracking::Prepared;

/// Removes from `doubts` the objects reported here, about which rays disagree because the surface is not closed.
pub(super) fn problems(prepared: &Prepared, rims: &Rims, doubts: &mut Doubts) -> Vec<Problem> {
    let description = &*prepared.description;
    let scene = &*prepared.scene;
    let mut problems = Vec::new();
    // Refractors are the first objects.
    for (index, (refractor, object)) in description.objects.refractors().iter().zip(&scene.objects).enumerate() {
        let id = ObjectId(index as u32);
        match (&refractor.shape, &object.topology) {
            (Shape::Quad { .. }, _) => {
                let problem = Problem::warning(
                    &refractor.name,
                    "open_mesh",
                    "a quad encloses nothing, so a refractor of that shape has no inside: what lies behind it counts as such, as far as \
                     the next surface",
                );
                problems.push(and_doubt(problem, doubts.remove(&id)));
            }
            (_, Some(topology)) => {
                // An interface must be replaced by closed bodies; its orientation does not matter then.
                let is_moot = |finding: &&Finding| {
                    rims.contains_key(&id)
                        && matches!(finding.kind, FindingKind::InsideOut | FindingKind::MixedOrientation)
                };
                for finding in topology.findings.iter().filter(|finding| !is_moot(finding)) {
                    let (count, spot) = match finding.kind {
                        // Parts that can be seen need no advice.
                        FindingKind::NestedComponents => match nested::hidden(prepared, id) {
                            Some(hidden) => hidden,
                            None => continue,
                        },
                        _ => (finding.count, spot(refractor, finding)),
                    };
                    let others = rims.get(&id).map(|others| names::list_of(scene, others));
                    let problem = problem(refractor, topology, finding.kind, count, spot, others.as_deref());
                    let is_open = matches!(topology.enclosure, Enclosure::Holed | Enclosure::Sheet);
                    problems.push(match finding.kind {
                        FindingKind::OpenMesh if is_open => and_doubt(problem, doubts.remove(&id)),
                        _ => problem,
                    });
                }
            }
            _ => {}
        }
    }
    problems
}

/// The same, with what is doubtful about its object because of it.
fn and_doubt(mut problem: Problem, doubt: Option<Doubt>) -> Problem {
    if let Some(Doubt { sentence, .. }) = doubt {
        problem.message += &format!(". Until then {sentence}");
    }
    problem
}

/// The place of a finding.
fn spot(refractor: &Object, finding: &Finding) -> Spot {
    let center = refractor.transform.matrix().transform_point3(finding.center);
    Spot { center, radius: finding.radius * refractor.transform.scale.abs().max_element() }
}

/// What is to be said of a finding at `spot`. `others` are the surfaces, by name, that the rim of one that is not closed is joined to.
fn problem(
    refractor: &Object,
    topology: &Topology,
    kind: FindingKind,
    count: u64,
    spot: Spot,
    others: Option<&str>,
) -> Problem {
    let of = |one: &str, many: &str| if count == 1 { format!("1 {one}") } else { format!("{count} {many}") };
    let faces = of("face", "faces");
    let components = of("separate part", "separate parts");
    let near = names::near(spot.center);
    let (severity, message) = match kind {
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
        FindingKind::OpenMesh => open(topology, count, &near, others),
        FindingKind::NonManifold if topology.enclosure == Enclosure::Union => (
            Severity::Advice,
            format!(
                "{} of the mesh, the first {near}, are shared by more than two faces: parts of it touch there, and count as one volume",
                of("edge", "edges")
            ),
        ),
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
                "{components} of the mesh, {near}, look inward and lie in another: a cavity, which holds what surrounds the object. Remove its \
                 faces if it should be filled"
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
    let problem = Problem { severity, ..Problem::warning(&refractor.name, kind.name(), message) };
    // A finding without extent concerns the whole object.
    if spot.radius > 0.0 { problem.at(spot.center, spot.radius) } else { problem }
}

/// An open boundary, by its width: from unmerged vertices to an open sheet.
fn open(topology: &Topology, count: u64, near: &str, others: Option<&str>) -> (Severity, String) {
    let edges = if count == 1 { "1 of its edges is".to_owned() } else { format!("{count} of its edges are") };
    let start = format!("the mesh is not closed: {edges} not shared by two faces that look the same way");
    let percent = topology.gap * 100.0;
    match topology.enclosure {
        Enclosure::Closed | Enclosure::Union => (
            Severity::Advice,
            format!("{start}, the first {near}. There is no gap, only vertices that do not match: merge them"),
        ),
        Enclosure::Holed | Enclosure::Sheet if let Some(others) = others => (
            Severity::Warning,
            format!(
                "{start}, {near}: it ends where {others} begin. They look like the interfaces of one body, each a sheet between two media. \
                 Give every medium an object of its own with a closed surface instead: a glass with its outer and inner wall, the liquid \
                 with the wall that it wets and its top"
            ),
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
