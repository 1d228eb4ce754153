//! The numbers of an object's shape.

use egui::{CollapsingHeader, DragValue, ScrollArea, Slider, Ui};
use glam::DVec3;

use crate::app::build::liquid::Inside;
use crate::app::build::profiles::Vessel;
use crate::app::build::{Addition, DEFAULT_FILL, vessel_of};
use crate::app::command::Command;
use crate::app::edit::ObjectEdit;
use crate::app::objects;
use crate::app::theme::CLOSE_MARK;
use crate::app::widgets::{
    Triple, XYZ, button_ui, combo_ui, fact_ui, note, number_ui, number_within_ui, row_ui, vector_ui, whole_ui,
};
use crate::scene::Description;
use crate::scene::description::{Object, Role, Shape};
use crate::scene::shapes::{MAX_SEGMENTS, MAX_SUBDIVISIONS};

/// Decimals that are shown; what was typed is kept in full.
const DECIMALS: usize = 4;
/// Height of the list of a profile's points.
const LIST_HEIGHT: f32 = 170.0;

/// Rows for the shape, and for what fills a vessel.
pub fn show(ui: &mut Ui, description: &Description, object: &Object, commands: &mut Vec<Command>) {
    let name = &object.name;
    let (min, max) = objects::bounds(&object.shape);
    let size = if object.shape.has_surface() { (max - min).length() } else { max.length().max(1.0) };
    let rows = Rows { name, speed: 0.004 * size.clamp(1e-9, 1e9) };
    let edited = match &object.shape {
        Shape::Sphere { center, radius } => {
            rows.ball(ui, *center, *radius).map(|(center, radius)| Shape::Sphere { center, radius })
        }
        Shape::Icosphere { center, radius, subdivisions } => {
            let ball = rows.ball(ui, *center, *radius);
            let about = "How often each triangle is divided into four.";
            let count = rows.count(ui, "Subdivisions", about, *subdivisions, 0..=MAX_SUBDIVISIONS);
            (ball.is_some() || count.is_some()).then(|| {
                let (center, radius) = ball.unwrap_or((*center, *radius));
                Shape::Icosphere { center, radius, subdivisions: count.unwrap_or(*subdivisions) }
            })
        }
        Shape::Box { min, max } => {
            let low = rows.vector(ui, "Min", "The lowest corner, in the object's own coordinates.", *min);
            let high = rows.vector(ui, "Max", "The highest corner, in the object's own coordinates.", *max);
            (low.is_some() || high.is_some())
                .then(|| Shape::Box { min: low.unwrap_or(*min), max: high.unwrap_or(*max) })
        }
        Shape::Cylinder { center, radius, height, segments } => {
            let new = Shape::Cylinder {
                center: rows.center(ui, *center),
                radius: rows.length(ui, "Radius", "Radius about the y axis.", *radius),
                height: rows.length(ui, "Height", "Length along the y axis.", *height),
                segments: rows.segments(ui, *segments),
            };
            Some(new)
        }
        Shape::Torus { center, major, minor, segments, rings } => {
            let new = Shape::Torus {
                center: rows.center(ui, *center),
                major: rows.length(ui, "Major", "Radius of the ring about the y axis.", *major),
                minor: rows.length(ui, "Minor", "Radius of the tube, less than the major one.", *minor),
                segments: rows.segments(ui, *segments),
                rings: rows.count(ui, "Rings", "Facets around the tube.", *rings, 3..=MAX_SEGMENTS).unwrap_or(*rings),
            };
            Some(new)
        }
        Shape::Lathe { profile, segments } => {
            let new = rows.profile(ui, profile);
            let count = rows.segments(ui, *segments);
            Some(Shape::Lathe { profile: new.unwrap_or_else(|| profile.clone()), segments: count })
        }
        Shape::Quad { center, edge_u, edge_v } => {
            let about = "An edge in full length. The front is where edge u × edge v points.";
            let new = Shape::Quad {
                center: rows.center(ui, *center),
                edge_u: rows.vector(ui, "Edge u", about, *edge_u).unwrap_or(*edge_u),
                edge_v: rows.vector(ui, "Edge v", about, *edge_v).unwrap_or(*edge_v),
            };
            Some(new)
        }
        Shape::Point { position } => Some(Shape::Point { position: rows.position(ui, *position) }),
        Shape::Spot { position, target, inner_angle, outer_angle } => {
            let about = "The place that it shines at, in the object's own coordinates.";
            let inner = "Angle to the axis within which it is brightest: half of the bright cone.";
            let outer = "Angle to the axis beyond which it is dark: half of the whole cone.";
            Some(Shape::Spot {
                position: rows.position(ui, *position),
                target: rows.vector(ui, "Target", about, *target).unwrap_or(*target),
                inner_angle: rows.angle(ui, "Inner angle", inner, *inner_angle, *outer_angle),
                outer_angle: rows.angle(ui, "Outer angle", outer, *outer_angle, 180.0).max(*inner_angle),
            })
        }
        Shape::Directional { direction, angle } => {
            let about = "The way that the light goes. Its length does not matter.";
            let sun = "Full angle under which the light is seen, 0 or from 0.001°. The sun's is 0.53°; at 0 shadows are sharp and nothing sees it.";
            let direction = rows.vector(ui, "Direction", about, *direction).unwrap_or(*direction);
            Some(Shape::Directional { direction, angle: rows.angle(ui, "Angle", sun, *angle, 180.0) })
        }
        Shape::Mesh { path, part, mesh, .. } => {
            fact_ui(ui, "Mesh", format!("{} triangles", mesh.triangles.len()), &path.display().to_string());
            for (label, name) in [("Group", &part.group), ("Material", &part.material)] {
                if let Some(name) = name {
                    fact_ui(ui, label, name.clone(), &format!("The part of {} that is shown", path.display()));
                }
            }
            None
        }
    };
    if let Some(shape) = edited
        && shape != object.shape
    {
        commands.push(Command::object(name, ObjectEdit::Shape(shape)));
    }
    smooth_ui(ui, object, commands);
    fill_ui(ui, description, object, commands);
}

/// Whether normals are interpolated, where that makes a difference.
fn smooth_ui(ui: &mut Ui, object: &Object, commands: &mut Vec<Command>) {
    let is_curved = !matches!(object.shape, Shape::Sphere { .. } | Shape::Quad { .. } | Shape::Box { .. });
    if !is_curved || matches!(object.role, Role::Light(_)) {
        return;
    }
    let about =
        "Whether light sees a smooth surface instead of the flat facets: normals are interpolated, sharp edges stay.";
    row_ui(ui, "Smooth", about, |ui| {
        let mut is_smooth = object.is_smooth();
        let label = format!("Smooth {}", object.name);
        if ui.checkbox(&mut is_smooth, "").accessible_name(label).on_hover_text(about).changed() {
            commands.push(Command::object(&object.name, ObjectEdit::Smooth(is_smooth)));
        }
    });
}

/// Per cent of a vessel's depth that a liquid may fill.
const FILLS: std::ops::RangeInclusive<f64> = 1.0..=99.0;
/// Width of the field for it, in points.
const FILL: f32 = 58.0;

/// The height of a liquid in its vessel; at a vessel, what fills it.
fn fill_ui(ui: &mut Ui, description: &Description, object: &Object, commands: &mut Vec<Command>) {
    if object.refractor().is_none() || !matches!(object.shape, Shape::Lathe { .. }) {
        return;
    }
    if let Some((vessel, inside, share)) = vessel_of(description, object) {
        let about = format!("How high it stands in {}, in per cent of the depth.", vessel.name);
        row_ui(ui, "Fill", &about, |ui| {
            let mut percent = share * 100.0;
            let label = format!("Fill height of {}", object.name);
            ui.spacing_mut().slider_width = (ui.available_width() - FILL - ui.spacing().item_spacing.x).max(40.0);
            let slider = Slider::new(&mut percent, FILLS).show_value(false);
            let is_dragged = ui.add(slider).accessible_name(&label).on_hover_text(&about).changed();
            let typed = DragValue::new(&mut percent).speed(0.2).suffix(" %").max_decimals(1);
            let is_typed = number_within_ui(ui, FILL, FILLS, typed, label, &about);
            if (is_dragged || is_typed)
                && let Ok(shape) = inside.filled(percent / 100.0)
            {
                commands.push(Command::object(&object.name, ObjectEdit::Shape(shape)));
            }
        });
    } else if Inside::of(&object.shape).is_ok() {
        let about = "A liquid up to two thirds of the depth, whose wall reaches into the glass. Its medium can be changed then.";
        row_ui(ui, "Contents", about, |ui| {
            let fill = Command::Add(Addition::Liquid(object.name.clone(), DEFAULT_FILL));
            button_ui(ui, "Fill with water", about, commands, fill);
        });
    }
}

/// Rows that give back what is new.
struct Rows<'a> {
    /// Of the object.
    name: &'a str,
    /// Scene units per point of a drag.
    speed: f64,
}

impl Rows<'_> {
    fn vector(&self, ui: &mut Ui, row: &str, about: &str, values: DVec3) -> Option<DVec3> {
        let label = format!("{row} of {} along", self.name);
        let triple = Triple { speeds: [self.speed; 3], decimals: DECIMALS, ..Triple::new(XYZ, &label, about) };
        row_ui(ui, row, about, |ui| vector_ui(ui, &triple, values))
    }

    fn center(&self, ui: &mut Ui, center: DVec3) -> DVec3 {
        self.vector(ui, "Centre", "In the object's own coordinates: before scale, rotation and move.", center)
            .unwrap_or(center)
    }

    fn position(&self, ui: &mut Ui, position: DVec3) -> DVec3 {
        let about = "In the object's own coordinates: before scale, rotation and move.";
        self.vector(ui, "Position", about, position).unwrap_or(position)
    }

    /// In degrees, from 0.
    fn angle(&self, ui: &mut Ui, row: &str, about: &str, value: f64, most: f64) -> f64 {
        let mut edited = value;
        row_ui(ui, row, about, |ui| {
            let drag = DragValue::new(&mut edited).speed(0.1).suffix("°").max_decimals(DECIMALS);
            number_within_ui(ui, 84.0, 0.0..=most, drag, format!("{row} of {}", self.name), about);
        });
        edited
    }

    fn length(&self, ui: &mut Ui, row: &str, about: &str, value: f64) -> f64 {
        let mut edited = value;
        row_ui(ui, row, about, |ui| {
            // Dragging stops short of 0; typed, anything is answered.
            let speed = (0.005 * value.abs()).max(1e-12);
            let drag = DragValue::new(&mut edited).speed(speed).max_decimals(DECIMALS);
            number_ui(ui, 84.0, drag, format!("{row} of {}", self.name), about);
        });
        edited
    }

    fn count(
        &self,
        ui: &mut Ui,
        row: &str,
        about: &str,
        value: u32,
        range: std::ops::RangeInclusive<u32>,
    ) -> Option<u32> {
        let mut edited = value;
        row_ui(ui, row, about, |ui| {
            let drag = DragValue::new(&mut edited).speed(0.3);
            let range = i64::from(*range.start())..=i64::from(*range.end());
            whole_ui(ui, 84.0, range, drag, format!("{row} of {}", self.name), about);
        });
        (edited != value).then_some(edited)
    }

    fn segments(&self, ui: &mut Ui, segments: u32) -> u32 {
        let about = "Facets around the y axis.";
        self.count(ui, "Segments", about, segments, 3..=MAX_SEGMENTS).unwrap_or(segments)
    }

    fn ball(&self, ui: &mut Ui, center: DVec3, radius: f64) -> Option<(DVec3, f64)> {
        let new = (self.center(ui, center), self.length(ui, "Radius", "In scene units, before the scale.", radius));
        (new != (center, radius)).then_some(new)
    }

    /// The points of a lathe, or those of a vessel in their place.
    fn profile(&self, ui: &mut Ui, profile: &[[f64; 2]]) -> Option<Vec<[f64; 2]>> {
        let mut edited: Option<Vec<[f64; 2]>> = None;
        row_ui(ui, "Profile", "Takes the outline of a vessel of the same height.", |ui| {
            combo_ui(ui, ("profile", self.name), format!("{} points", profile.len()), |ui| {
                for vessel in Vessel::ALL {
                    if ui.button(vessel.name).clicked() {
                        let [low, high] = range(profile);
                        let height = if high > low { high - low } else { 1.0 };
                        let moved = vessel.profile(height).into_iter().map(|[r, y]| [r, y + low.min(high)]);
                        edited = Some(moved.collect());
                        ui.close();
                    }
                }
            });
        });
        let header = CollapsingHeader::new("Points (radius, height)").id_salt(("points", self.name));
        header.show(ui, |ui| {
            let height = ui.spacing().interact_size.y;
            let area = ScrollArea::vertical().id_salt("points").max_height(LIST_HEIGHT).auto_shrink([false, true]);
            area.show_rows(ui, height, profile.len(), |ui, rows| {
                for index in rows {
                    if let Some(new) = self.point_ui(ui, profile, index) {
                        edited = Some(new);
                    }
                }
            });
            ui.label(note(ui, "From the axis around the rim and back; + adds a point behind."));
        });
        edited
    }

    /// One point, with buttons to add one behind it and to remove it.
    fn point_ui(&self, ui: &mut Ui, profile: &[[f64; 2]], index: usize) -> Option<Vec<[f64; 2]>> {
        let mut edited = profile.to_vec();
        let mut is_changed = false;
        let number = index + 1;
        ui.horizontal(|ui| {
            let (size, gap) = (ui.spacing().interact_size.y, ui.spacing().item_spacing.x);
            let width = ((ui.available_width() - 2.0 * size - 4.0 * gap - 26.0) / 2.0).max(30.0);
            ui.add_sized([22.0, size], egui::Label::new(note(ui, number.to_string())));
            for (part, (letter, word)) in [("r", "radius"), ("y", "height")].into_iter().enumerate() {
                let drag = DragValue::new(&mut edited[index][part]).speed(self.speed).max_decimals(DECIMALS);
                let label = format!("Point {number} of {}, {word}", self.name);
                is_changed |= number_ui(
                    ui,
                    width,
                    drag.prefix(format!("{letter} ")),
                    label,
                    format!("The {word} of point {number}."),
                );
            }
            let add = ui.add_sized([size, size], egui::Button::new("+")).on_hover_text("Add a point behind this one.");
            if add.accessible_name(format!("Add a point behind point {number}")).clicked() {
                let [a, b] = [profile[index], profile[(index + 1) % profile.len()]];
                edited.insert(index + 1, [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]);
                is_changed = true;
            }
            let remove = ui.add_sized([size, size], egui::Button::new(CLOSE_MARK)).on_hover_text("Remove this point.");
            if remove.accessible_name(format!("Remove point {number}")).clicked() {
                edited.remove(index);
                is_changed = true;
            }
        });
        is_changed.then_some(edited)
    }
}

/// Lowest and highest y.
fn range(profile: &[[f64; 2]]) -> [f64; 2] {
    (profile.iter()).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [_, y]| [low.min(*y), high.max(*y)])
}
