//! Refractors, solids and lights.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::files::Files;
use super::node::{Node, Table};
use super::shape::{self, MeshCache};
use super::suggest::suggestion;
use crate::optics::{Medium, catalog, medium};
use crate::scene::SceneError;
use crate::scene::description::{Light, Object, Objects, Paint, Refractor, Shape, Solid, Transform};
use crate::scene::shapes::{MAX_LENGTH, MIN_LENGTH};

/// Albedo of a solid that gives none.
pub(crate) const DEFAULT_ALBEDO: [f64; 3] = [0.8; 3];

/// Reads objects; knows the names and meshes met so far.
pub(super) struct Reader<'a> {
    files: Files<'a>,
    media: &'a [Medium],
    media_names: HashSet<&'a str>,
    /// Names of all objects so far, with what they are.
    names: HashMap<String, &'static str>,
    meshes: MeshCache,
}

impl<'a> Reader<'a> {
    pub fn new(files: Files<'a>, media: &'a [Medium]) -> Self {
        let media_names = media.iter().map(|medium| medium.name.as_str()).collect();
        Self { files, media, media_names, names: HashMap::new(), meshes: MeshCache::default() }
    }

    pub fn objects(&mut self, root: &Table<'_>) -> Result<Objects, SceneError> {
        let (refractors, solids, lights) = (self.refractors(root)?, self.solids(root)?, self.lights(root)?);
        Ok(refractors.into_iter().chain(solids).chain(lights).collect())
    }

    fn refractors(&mut self, root: &Table<'_>) -> Result<Vec<Object>, SceneError> {
        const KEYS: [&str; 8] = ["name", "medium", "shape", "priority", "roughness", "smooth", "visible", "transform"];
        let mut refractors = Vec::new();
        for table in root.read("refractor", Vec::new(), Node::tables)? {
            let (name, table) = self.begin(table, "refractor", &KEYS)?;
            if let Some(node) = table.get("roughness")
                && node.number_that("between 0 and 1", |x| (0.0..=1.0).contains(&x))? != 0.0
            {
                return Err(node.error("rough surfaces are not yet supported; set `roughness` to 0 or remove it"));
            }
            let medium = self.medium(&table.need("medium")?)?;
            let (shape, transform) = self.shape(&table)?;
            let priority = table.read("priority", 0, |node| node.integer(i32::MIN..=i32::MAX))?;
            let smooth = table.read("smooth", false, Node::boolean)?;
            let visible = table.read("visible", true, Node::boolean)?;
            let role = Refractor { medium, priority, smooth }.into();
            refractors.push(Object { name, shape, transform, visible, role });
        }
        Ok(refractors)
    }

    fn solids(&mut self, root: &Table<'_>) -> Result<Vec<Object>, SceneError> {
        const KEYS: [&str; 8] = ["name", "shape", "color", "checker", "mirror", "smooth", "visible", "transform"];
        let mut solids = Vec::new();
        for table in root.read("solid", Vec::new(), Node::tables)? {
            let (name, table) = self.begin(table, "solid", &KEYS)?;
            let paint = match (table.get("color"), table.get("checker")) {
                (Some(_), Some(checker)) => {
                    return Err(checker.error(format!("solid `{name}` has both `color` and `checker`; remove one")));
                }
                (Some(color), None) => Paint::Color(color.albedo()?),
                (None, Some(checker)) => self::checker(&checker.table()?)?,
                (None, None) => Paint::Color(DEFAULT_ALBEDO),
            };
            let (shape, transform) = self.shape(&table)?;
            let mirror = table.read("mirror", false, Node::boolean)?;
            let smooth = table.read("smooth", false, Node::boolean)?;
            let visible = table.read("visible", true, Node::boolean)?;
            solids.push(Object { name, shape, transform, visible, role: Solid { paint, mirror, smooth }.into() });
        }
        Ok(solids)
    }

    fn lights(&mut self, root: &Table<'_>) -> Result<Vec<Object>, SceneError> {
        let mut lights = Vec::new();
        for table in root.read("light", Vec::new(), Node::tables)? {
            let (name, table) = self.begin(table, "light", &["name", "shape", "radiance", "visible", "transform"])?;
            let (shape, transform) = self.shape(&table)?;
            let radiance = table.need("radiance")?.radiance()?;
            let visible = table.read("visible", true, Node::boolean)?;
            lights.push(Object { name, shape, transform, visible, role: Light { radiance }.into() });
        }
        Ok(lights)
    }

    /// Checks an object's keys and name; later errors call the table by that name.
    fn begin<'t>(
        &mut self,
        table: Table<'t>,
        kind: &'static str,
        keys: &[&str],
    ) -> Result<(String, Table<'t>), SceneError> {
        let table = table.renamed(format!("[[{kind}]]"));
        table.only(keys)?;
        let node = table.need("name")?;
        let name = node.words()?.to_owned();
        if matches!(name.as_str(), medium::WORLD | medium::VACUUM) {
            return Err(node.error(format!("`{name}` is a reserved name; call the {kind} something else")));
        }
        if let Some(other) = self.names.insert(name.clone(), kind) {
            return Err(
                node.error(format!("there is already a {other} called `{name}`; names of objects must be unique"))
            );
        }
        let table = table.renamed(format!("{kind} `{name}`"));
        Ok((name, table))
    }

    fn medium(&self, node: &Node<'_>) -> Result<String, SceneError> {
        let name = node.words()?;
        let names = || self.media.iter().map(|medium| medium.name.as_str());
        if self.media_names.contains(name) {
            return Ok(name.to_owned());
        }
        let hint = if matches!(name, medium::WORLD | medium::VACUUM) {
            "; the name is reserved: give this object a [[medium]] of its own, with the same IOR".to_owned()
        } else if let Some(entry) = catalog::find(name) {
            format!("; the catalogue has it: add a [[medium]] with ior = {{ catalog = \"{}\" }}", entry.name)
        } else {
            suggestion(name, names())
        };
        let list = names().collect::<Vec<_>>().join(", ");
        let list = if list.is_empty() { "it has none".to_owned() } else { format!("media: {list}") };
        Err(node.error(format!("the scene has no medium `{name}`{hint}; {list}")))
    }

    fn shape(&mut self, table: &Table<'_>) -> Result<(Shape, Transform), SceneError> {
        let shape = shape::shape(&table.need("shape")?, self.files, &mut self.meshes)?;
        let Some(node) = table.get("transform") else { return Ok((shape, Transform::IDENTITY)) };
        let transform = self::transform(&node.table()?)?;
        let s = transform.scale.abs();
        if matches!(shape, Shape::Sphere { .. }) && (s.x != s.y || s.y != s.z) {
            return Err(node
                .error("a `sphere` is analytic and cannot be scaled differently along its axes; use an `icosphere`"));
        }
        Ok((shape, transform))
    }
}

fn checker(table: &Table<'_>) -> Result<Paint, SceneError> {
    table.only(&["a", "b", "size"])?;
    Ok(Paint::Checker {
        a: table.need("a")?.albedo()?,
        b: table.need("b")?.albedo()?,
        size: table.need("size")?.number_that("greater than 0", |x| x > 0.0)?,
    })
}

fn transform(table: &Table<'_>) -> Result<Transform, SceneError> {
    table.only(&["scale", "rotate", "translate"])?;
    let scale = table.read("scale", DVec3::ONE, |node| {
        let scale = if node.is_number() { DVec3::splat(node.number()?) } else { node.vec3()? };
        if scale.to_array().contains(&0.0) {
            return Err(node.error("`scale` must not be 0"));
        }
        if scale.abs().min_element() < MIN_LENGTH {
            return Err(node.error(format!("`scale` is too small, must be at least {MIN_LENGTH:e}")));
        }
        within_reach(node, scale)
    })?;
    Ok(Transform {
        scale,
        rotate: table.read("rotate", DVec3::ZERO, Node::vec3)?,
        translate: table.read("translate", DVec3::ZERO, |node| within_reach(node, node.vec3()?))?,
    })
}

/// Refuses numbers that would carry a shape beyond what can be computed with.
fn within_reach(node: &Node<'_>, v: DVec3) -> Result<DVec3, SceneError> {
    if v.abs().max_element() <= MAX_LENGTH {
        Ok(v)
    } else {
        Err(node.error(format!("{} is too large, must be at most {MAX_LENGTH:e}", node.name)))
    }
}
