//! What a scene says and no picture shows yet: it is kept, and written for renderers that show it.

use std::collections::HashSet;

use super::{Problem, names};
use crate::optics::Ior;
use crate::scene::description::{Description, Object};

/// Values that one message lists at the most.
const MOST_VALUES: usize = 8;

/// One finding a kind, for notes beside pictures too.
pub fn unrendered(description: &Description) -> Vec<Problem> {
    dispersion(description).into_iter().chain(roughness(description)).chain(thin(description)).collect()
}

fn dispersion(description: &Description) -> Option<Problem> {
    let used: HashSet<&str> =
        description.objects.refractor_roles().map(|r| r.medium.as_str()).chain(description.declared()).collect();
    let used = description.media.iter().filter(|m| used.contains(m.name.as_str()));
    let used = used.map(|m| (m.name.as_str(), &m.ior));
    let dispersive: Vec<(&str, &Ior)> = ([("world", &description.world.ior)].into_iter().chain(used))
        // A catalogue's entry is asked for by name, and its IOR is shown; a formula was written for its dispersion.
        .filter(|(_, ior)| ior.is_dispersive() && !matches!(ior, Ior::Catalog(_)))
        .collect();
    let value = |(name, ior): &(&str, &Ior)| format!("{name} {:.4}", ior.ior());
    let message = format!(
        "dispersion is not rendered yet: every colour gets the IOR at 587.56 nm ({})",
        values(dispersive.iter().map(value))
    );
    let place = names::place(dispersive.iter().map(|(name, _)| *name));
    (!dispersive.is_empty()).then(|| Problem::advice(place, "dispersion", message))
}

fn roughness(description: &Description) -> Option<Problem> {
    let rough: Vec<&Object> = description.objects.iter().filter(|object| object.roughness() != [0.0; 2]).collect();
    let value = |object: &&Object| match object.roughness() {
        [u, v] if u == v => format!("{} {}", object.name, names::brief(u, 3)),
        [u, v] => format!("{} {} along u and {} along v", object.name, names::brief(u, 3), names::brief(v, 3)),
    };
    let message = format!(
        "roughness is not rendered yet: what is rough is shown as smooth ({}). The scene keeps it, and exports have it",
        values(rough.iter().map(value))
    );
    let place = names::place(rough.iter().map(|object| object.name.as_str()));
    (!rough.is_empty()).then(|| Problem::advice(place, "roughness", message))
}

fn thin(description: &Description) -> Vec<Problem> {
    let thin = description.objects.iter().filter(|object| object.refractor().is_some_and(|refractor| refractor.thin));
    let (shown, hidden): (Vec<&Object>, Vec<&Object>) = thin.partition(|object| object.visible);
    let problem = |walls: &[&Object], kind, message: &str| {
        let place = names::place(walls.iter().map(|object| object.name.as_str()));
        (!walls.is_empty()).then(|| Problem::advice(place, kind, message))
    };
    let as_body = "thin walls are not rendered yet: this one is shown as a body of its medium. Hide it (`visible = false`), and light goes \
                   straight through";
    let as_bodies = "thin walls are not rendered yet: these are shown as bodies of their media. Hide them (`visible = false`), and light goes \
                     straight through";
    let hidden_text = "thin walls are not rendered yet: light goes straight through what is hidden, without reflections. Exports have it as a \
                       thin wall";
    let shown_text = if shown.len() == 1 { as_body } else { as_bodies };
    [problem(&shown, "thin_as_body", shown_text), problem(&hidden, "thin_hidden", hidden_text)]
        .into_iter()
        .flatten()
        .collect()
}

fn values(all: impl Iterator<Item = String>) -> String {
    all.take(MOST_VALUES).collect::<Vec<_>>().join(", ")
}
