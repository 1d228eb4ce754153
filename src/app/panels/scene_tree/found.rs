//! What rectification found of refractors, for their rows and cards: what contains them, and how sure that is.

use crate::app::state::State;
use crate::rectify::Patch;
use crate::scene::Description;
use crate::scene::ObjectId;
use crate::session::SceneReport;
use crate::tracking::Prepared;

/// A row of the tree: a refractor by index, and how deep it is.
pub struct Row {
    pub refractor: usize,
    pub depth: usize,
    /// For each level above, whether a line goes on down to a later sibling.
    pub continues: Vec<bool>,
}

/// The rows of the tree, parents before children, siblings in file order. Before the first rectification everything is at the top.
pub fn rows(description: &Description, report: Option<&SceneReport>) -> Vec<Row> {
    let count = description.objects.refractors().len();
    let parent = |index: usize| -> Option<usize> {
        let container = container_of(report?, &description.objects.refractors()[index].name)?.0 as usize;
        (container < count && container != index).then_some(container)
    };
    let mut children = vec![Vec::new(); count + 1];
    for index in 0..count {
        children[parent(index).map_or(0, |p| p + 1)].push(index);
    }
    let mut rows = Vec::with_capacity(count);
    let mut is_listed = vec![false; count];
    list(&children, 0, &mut Vec::new(), &mut rows, &mut is_listed);
    // Two objects that each seem to contain the other are below no root; they are shown nevertheless.
    let lost = is_listed.iter().enumerate().filter(|(_, is_listed)| !**is_listed);
    rows.extend(lost.map(|(index, _)| Row { refractor: index, depth: 1, continues: Vec::new() }));
    rows
}

fn list(children: &[Vec<usize>], of: usize, continues: &mut Vec<bool>, rows: &mut Vec<Row>, is_listed: &mut [bool]) {
    for (place, &index) in children[of].iter().enumerate() {
        if std::mem::replace(&mut is_listed[index], true) {
            continue;
        }
        continues.push(place + 1 < children[of].len());
        rows.push(Row { refractor: index, depth: continues.len(), continues: continues.clone() });
        list(children, index + 1, continues, rows, is_listed);
        continues.pop();
    }
}

/// The answer for a refractor, by name: the description may be newer than the report.
pub fn patch_of<'a>(report: &'a SceneReport, refractor: &str) -> Option<&'a Patch> {
    let scene = &report.prepared.scene;
    let (id, _) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor)?;
    report.prepared.table.main_patch(id)
}

/// The refractor that most of a refractor's surface lies in; `None`: the global medium, or not known yet.
fn container_of(report: &SceneReport, refractor: &str) -> Option<ObjectId> {
    let Prepared { scene, table, .. } = &report.prepared;
    let (id, _) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor)?;
    match table.known_containers() {
        Some(containers) => containers.parent_of(id),
        None => table.main_patch(id)?.outside_refractor,
    }
}

/// What the parts of a refractor's surface lie in, in words, where that is more than one thing.
pub fn mixture(report: &SceneReport, refractor: &str) -> Option<String> {
    let Prepared { scene, table, .. } = &report.prepared;
    let (id, _) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor)?;
    let parts = table.known_containers().filter(|containers| containers.is_mixed(id))?.parts_of(id);
    let words: Vec<String> = parts
        .iter()
        .map(|part| {
            let container = part.container.map_or(crate::optics::medium::WORLD, |id| &scene.object(id).name);
            format!("{:.0} % in {container}", part.share * 100.0)
        })
        .collect();
    Some(format!(
        "It crosses a boundary: of its surface, {}. It stands below what most of it lies in.",
        words.join(", ")
    ))
}

/// The media that a light shines into, in words; `None` before the first rectification, and of a hidden light.
pub fn shines_into(state: &State, light: &str) -> Option<String> {
    let Prepared { scene, table, .. } = &state.report.as_deref()?.prepared;
    let patches = table.lights.iter().filter(|patch| scene.object(patch.refractor).name == light);
    let mut found: Vec<&str> = Vec::new();
    for patch in patches {
        let name = patch.outside.map_or("several media", |medium| &scene.medium(medium).name);
        if !found.contains(&name) {
            found.push(name);
        }
    }
    (!found.is_empty()).then(|| found.join(", "))
}

/// What rectification found outside a refractor, in words: where it differs from place to place, everything.
pub fn outside(state: &State, refractor: &str) -> String {
    let Some(report) = state.report.as_deref() else { return "…".to_owned() };
    let scene = &report.prepared.scene;
    let Some((id, _)) = scene.refractors().find(|(id, _)| scene.object(*id).name == refractor) else {
        return "…".to_owned();
    };
    let mut found: Vec<String> = Vec::new();
    for patch in report.prepared.table.patches_of(id) {
        let Some(outside) = patch.outside else { continue };
        let medium = &scene.medium(outside).name;
        let text = match patch.outside_refractor {
            Some(container) if scene.object(container).name != *medium => {
                format!("{medium} ({})", scene.object(container).name)
            }
            _ => medium.clone(),
        };
        if !found.contains(&text) {
            found.push(text);
        }
    }
    if report.prepared.table.patches_of(id).is_empty() {
        // Hidden.
        "—".to_owned()
    } else if found.is_empty() {
        "differs from place to place".to_owned()
    } else {
        found.join(", ")
    }
}
