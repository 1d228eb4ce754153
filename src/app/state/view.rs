//! Where the camera stands, and what is picked in the picture.

use glam::DVec3;

use super::State;
use crate::app::command::Command;
use crate::app::{navigation, objects};
use crate::check::Spot;
use crate::geometry::Ray;
use crate::scene::camera::Camera;
use crate::scene::description::{CameraDescription, Shape};
use crate::transport::inspect::{Follow, trace};

/// Views that can be returned to.
const MAX_EARLIER_VIEWS: usize = 50;

/// What the pointer did, in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    Orbit([f32; 2]),
    Pan([f32; 2]),
    /// Wheel notches, positive towards the target.
    Dolly(f32),
}

impl State {
    /// The camera that the films are taken with: in a pane that is higher than wide the field of view goes over the width, or the sides
    /// of the scene would be cut off.
    pub fn film_camera(&self) -> CameraDescription {
        let [width, height] = self.size.film.map(f64::from);
        let camera = self.view.camera;
        if width >= height || width == 0.0 {
            return camera;
        }
        let half = (camera.vertical_fov.to_radians() / 2.0).tan() * height / width;
        CameraDescription { vertical_fov: 2.0 * half.atan().to_degrees(), ..camera }
    }

    pub(super) fn set_camera(&mut self, camera: CameraDescription) {
        if camera != self.view.camera && Camera::new(&camera).is_ok() {
            self.view.camera = camera;
            self.invalidate();
        }
    }

    pub(super) fn look_at(&mut self, point: [f64; 2]) {
        let (Some(report), Ok(camera)) = (&self.report, Camera::new(&self.film_camera())) else { return };
        let ray = ray_through(&camera, self.size.film, point);
        let mode = self.settings.panes[self.view.active_pane].inspected_mode();
        let path = trace(&report.prepared, mode, ray, Follow::Transmit, 0, Some(1));
        if let Some(vertex) = path.vertices.first() {
            self.jump_to(CameraDescription { target: vertex.position.into(), ..self.view.camera });
        }
    }

    pub(super) fn select_at(&mut self, point: [f64; 2]) {
        let (Some(report), Ok(camera)) = (&self.report, Camera::new(&self.film_camera())) else { return };
        let scene = &report.prepared.scene;
        let mut ray = ray_through(&camera, self.size.film, point);
        ray.origin -= scene.geometry.origin;
        let mut names: Vec<&str> = Vec::new();
        for hit in scene.geometry.all_hits(&ray) {
            let name = &*scene.objects[scene.geometry.object_of(hit.primitive) as usize].name;
            if !names.contains(&name) {
                names.push(name);
            }
        }
        // A few pixels apart is the same place.
        let is_again = self.last_pick.is_some_and(|last| (0..2).all(|i| (last[i] - point[i]).abs() < 0.01));
        let shown = self.selected.as_deref().filter(|_| is_again);
        let next = shown.and_then(|shown| names.iter().position(|name| *name == shown)).map_or(0, |at| at + 1);
        self.selected = names.get(if next < names.len() { next } else { 0 }).map(|&name| name.to_owned());
        self.last_pick = Some(point);
    }

    /// Moves the camera to a view that is not next to the present one, which is kept to return to.
    pub(super) fn jump_to(&mut self, camera: CameraDescription) {
        let before = self.view.camera;
        self.set_camera(camera);
        if self.view.camera != before {
            self.earlier_views.push(before);
            if self.earlier_views.len() > MAX_EARLIER_VIEWS {
                self.earlier_views.remove(0);
            }
        }
    }

    pub(super) fn frame_object(&mut self, name: &str) {
        let Some(object) = self.document.description().objects.find(name) else { return };
        if matches!(object.shape, Shape::Directional { .. }) {
            // It is nowhere.
            return;
        }
        let (min, max) = objects::scene_bounds(object);
        let is_ball = matches!(object.shape, Shape::Sphere { .. } | Shape::Icosphere { .. });
        let radius = if is_ball { (max.x - min.x) / 2.0 } else { (max - min).length() / 2.0 };
        self.frame((min + max) / 2.0, radius);
    }

    pub(super) fn show_problem(&mut self, names: &[String], spot: Option<Spot>) {
        if let Some(name) = names.first() {
            self.selected = Some(name.clone());
        }
        let all = &self.document.description().objects;
        let boxes: Vec<_> = names.iter().filter_map(|name| all.find(name)).map(objects::scene_bounds).collect();
        let (center, radius) = match (spot, &boxes[..]) {
            (Some(spot), _) => (spot.center, spot.radius),
            (None, []) => return,
            (None, [first, others @ ..]) => {
                let common = others.iter().fold(*first, |a, b| (a.0.max(b.0), a.1.min(b.1)));
                let all = others.iter().fold(*first, |a, b| (a.0.min(b.0), a.1.max(b.1)));
                // What two objects have to do with each other is where both are.
                let (min, max) = if common.0.cmplt(common.1).all() { common } else { all };
                ((min + max) / 2.0, (max - min).length() / 2.0)
            }
        };
        self.frame(center, radius);
    }

    /// Keeps the direction of the view and moves the camera so that a sphere of `radius` around `center` fills a good part of the picture.
    pub(super) fn frame(&mut self, center: DVec3, radius: f64) {
        let aspect = f64::from(self.size.film[0].max(1)) / f64::from(self.size.film[1].max(1));
        // A light without a surface is a point, which is seen with what is around it.
        let radius = if radius > 0.0 { radius } else { 0.1 * center.distance(self.view.camera.position) };
        let tan_vertical = (self.film_camera().vertical_fov.to_radians() / 2.0).tan();
        self.jump_to(navigation::framed(&self.view.camera, center, radius, tan_vertical * aspect.min(1.0)));
        if self.view.zoom > 1.0 {
            self.view.zoom = 1.0;
            self.view.zoom_center = [0.5; 2];
        }
    }

    /// Moves the camera by what the pointer did in a pane of `height` points.
    pub fn navigate(&self, motion: Motion, height: f32) -> Command {
        let per_height =
            |drag: [f32; 2]| glam::DVec2::new(f64::from(drag[0]), f64::from(drag[1])) / f64::from(height.max(1.0));
        Command::SetCamera(match motion {
            Motion::Orbit(drag) => navigation::orbit(&self.view.camera, per_height(drag)),
            Motion::Pan(drag) => navigation::pan(&self.view.camera, per_height(drag)),
            Motion::Dolly(steps) => {
                let scene = self.document.description().camera;
                // Small against the scene.
                let near = 0.02 * scene.position.distance(scene.target);
                navigation::dolly(&self.view.camera, f64::from(steps), near)
            }
        })
    }
}

/// The ray through the middle of the pixel at a point in [0, 1]² of the film, from the middle of the lens.
pub(super) fn ray_through(camera: &Camera, film_size: [u32; 2], point: [f64; 2]) -> Ray {
    let size = glam::UVec2::from(film_size).as_dvec2();
    let pixel = (size * glam::DVec2::from(point)).floor() + 0.5;
    camera.ray(pixel.min(size - 0.5), size, glam::DVec2::ZERO)
}
