//! Where the slice lies that panes show: which way it faces, how far along its normal, and what part of it is seen.

use glam::{DMat2, DVec2, DVec3};

use super::state::State;
use crate::render::slice::Plane;
use crate::scene::ObjectId;
use crate::scene::camera::Camera;

/// Largest and smallest magnification.
pub const ZOOM: std::ops::RangeInclusive<f64> = 0.2..=1000.0;
/// Room around the scene at magnification 1.
const ROOM: f64 = 1.08;

/// Which way a slice faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Facing {
    X,
    Y,
    Z,
    /// The camera, wherever it stands.
    Camera,
    /// The normal of a plane through a path, and a point of it.
    Path {
        point: DVec3,
        normal: DVec3,
    },
}

impl Facing {
    /// The coordinate axis that it faces along.
    fn axis(self) -> Option<DVec3> {
        match self {
            Self::X => Some(DVec3::X),
            Self::Y => Some(DVec3::Y),
            Self::Z => Some(DVec3::Z),
            Self::Camera | Self::Path { .. } => None,
        }
    }

    /// What the distance along the normal is called.
    pub fn offset_name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Camera | Self::Path { .. } => "Distance",
        }
    }
}

/// A slice as it was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SliceView {
    pub facing: Facing,
    /// In scene units: the coordinate of an axis; towards the camera from its target; or from the path's plane.
    pub offset: f64,
    /// Magnification; at 1 all of the refractors is seen.
    pub zoom: f64,
    /// How far the middle of the picture is from that of the refractors, in scene units.
    pub pan: DVec3,
}

impl SliceView {
    /// `None` where a number is not finite; magnification is kept in [`ZOOM`].
    pub fn sound(mut self) -> Option<Self> {
        if let Facing::Path { point, normal } = &mut self.facing {
            *normal = normal.try_normalize().filter(|_| point.is_finite())?;
        }
        self.zoom = self.zoom.clamp(*ZOOM.start(), *ZOOM.end());
        (self.offset.is_finite() && self.zoom.is_finite() && self.pan.is_finite()).then_some(self)
    }
}

/// The plane of a slice with what is needed to move it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    pub view: SliceView,
    pub plane: Plane,
    /// Direction in which the offset grows.
    pub along: DVec3,
    /// Least and largest offset that meets the refractors.
    pub range: [f64; 2],
}

impl State {
    /// The slice as chosen; at first through the middle of the refractors, seen from the camera's side.
    pub fn slice_view(&self) -> SliceView {
        self.slice.unwrap_or_else(|| {
            let (low, high) = self.refractor_box();
            let middle = (low + high) / 2.0;
            let sight = self.view.camera.target - self.view.camera.position;
            let (facing, offset) =
                if sight.x.abs() > sight.z.abs() { (Facing::X, middle.x) } else { (Facing::Z, middle.z) };
            SliceView { facing, offset, zoom: 1.0, pan: DVec3::ZERO }
        })
    }

    /// Where the slice lies; `None` before there is a scene.
    pub fn placed_slice(&self) -> Option<Placed> {
        self.report.as_ref()?;
        let camera = Camera::new(&self.film_camera()).ok()?;
        let [width, height] = self.film_size().map(f64::from);
        if width < 1.0 || height < 1.0 {
            return None;
        }
        let view = self.slice_view();
        let (low, high) = self.refractor_box();
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        // Where the offset counts from, and in which direction.
        let (pivot, along) = match view.facing {
            Facing::X | Facing::Y | Facing::Z => (DVec3::ZERO, view.facing.axis()?),
            Facing::Camera => (self.view.camera.target, -camera.forward),
            Facing::Path { point, normal } => (point, normal),
        };
        // Seen from where the camera is.
        let normal = if (camera.position - middle).dot(along) < 0.0 { -along } else { along };
        let up = match view.facing {
            Facing::Camera => camera.up,
            // Up in a plan is away from the viewer.
            _ if normal.y.abs() > 0.9 => {
                let flat = DVec3::new(camera.forward.x, 0.0, camera.forward.z);
                if flat.x.abs() > flat.z.abs() { DVec3::X * flat.x.signum() } else { DVec3::Z * flat.z.signum() }
            }
            _ => DVec3::Y,
        };
        let right = up.cross(normal).try_normalize()?;
        let up = normal.cross(right);
        let reach = |direction: DVec3| direction.abs().dot(half);
        let aspect = width / height;
        let whole = ROOM * 2.0 * reach(up).max(reach(right) / aspect);
        let at = middle + view.pan;
        let center = at + along * (along.dot(pivot - at) + view.offset);
        let plane = Plane { center, right, up, height: whole.max(1e-9) / view.zoom };
        let (offset, room) = (along.dot(middle - pivot), ROOM * reach(along));
        Some(Placed { view, plane, along, range: [offset - room, offset + room] })
    }

    /// The slice through the middle of the selected object.
    pub fn slice_through_selected(&self) -> Option<SliceView> {
        let scene = &self.report.as_ref()?.prepared.scene;
        let selected = self.selected.as_deref()?;
        let index = scene.objects.iter().position(|object| object.name == selected)?;
        let (low, high) = scene.geometry.bounds_of(index as u32);
        if low.x > high.x {
            return None;
        }
        let placed = self.placed_slice()?;
        let middle = (low + high) / 2.0 + scene.geometry.origin;
        let moved = (middle - placed.plane.center).dot(placed.along);
        Some(SliceView { offset: placed.view.offset + moved, ..placed.view })
    }

    /// The slice that contains the inspected pixel's ray and comes nearest to the rest of its path.
    pub fn slice_through_path(&self) -> Option<SliceView> {
        let inspection = self.inspection.as_ref()?;
        let path = inspection.path(self.settings.panes[self.view.active_pane].inspected_mode())?;
        let camera = Camera::new(&self.film_camera()).ok()?;
        let mut places: Vec<DVec3> = path.vertices.iter().map(|vertex| DVec3::from(vertex.position)).collect();
        let point = *places.first()?;
        if path.escaped {
            places.push(places[places.len() - 1] + DVec3::from(path.final_direction));
        }
        let normal = normal_of_path(DVec3::from(path.origin), camera.right, &places)?;
        Some(SliceView { facing: Facing::Path { point, normal }, offset: 0.0, ..self.slice_view() })
    }

    /// The box around all refractors, or around everything where there is none.
    fn refractor_box(&self) -> (DVec3, DVec3) {
        const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let Some(report) = &self.report else { return (-DVec3::ONE, DVec3::ONE) };
        let scene = &report.prepared.scene;
        let around = |only_refractors: bool| {
            let counts = |index: &u32| !only_refractors || scene.is_refractor(ObjectId(*index));
            let boxes = (0..scene.objects.len() as u32).filter(counts).map(|index| scene.geometry.bounds_of(index));
            boxes.fold(NOTHING, |a, b| (a.0.min(b.0), a.1.max(b.1)))
        };
        let found = [around(true), around(false)].into_iter().find(|(low, high)| low.cmple(*high).all());
        found.map_or((-DVec3::ONE, DVec3::ONE), |(low, high)| {
            (low + scene.geometry.origin, high + scene.geometry.origin)
        })
    }
}

/// The normal of the plane that contains the first segment and comes nearest to the other vertices; with `right` as the normal where they all
/// lie on one line.
fn normal_of_path(start: DVec3, right: DVec3, places: &[DVec3]) -> Option<DVec3> {
    let direction = (*places.first()? - start).try_normalize()?;
    let first = direction.any_orthonormal_vector();
    let second = direction.cross(first);
    let spread = places.iter().copied().fold(DMat2::ZERO, |sum, place| {
        let away = DVec2::new((place - start).dot(first), (place - start).dot(second));
        sum + DMat2::from_cols(away * away.x, away * away.y)
    });
    // The direction of largest spread lies in the plane.
    let (a, b, c) = (spread.x_axis.x, spread.x_axis.y, spread.y_axis.y);
    let size = (places[places.len() - 1] - start).length();
    if a + c <= 1e-12 * size * size {
        return (right - direction * right.dot(direction)).try_normalize();
    }
    let angle = 0.5 * (2.0 * b).atan2(a - c);
    let within = first * angle.cos() + second * angle.sin();
    direction.cross(within).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_path_lies_in_its_plane() {
        for normal in [DVec3::X, DVec3::new(0.2, 0.9, -0.4).normalize(), DVec3::new(-1.0, 1.0, 0.1).normalize()] {
            let side = normal.any_orthonormal_vector();
            let other = normal.cross(side);
            let places = [(0.0, 3.0), (0.5, 5.0), (1.5, 6.0)].map(|(a, b)| side * a + other * b);
            let found = normal_of_path(DVec3::ZERO, side, &places).unwrap();
            assert!(found.dot(normal).abs() > 1.0 - 1e-9, "{found} for {normal}");
        }
    }

    #[test]
    fn a_straight_path_has_an_upright_plane() {
        let places = [DVec3::NEG_Z * 2.0, DVec3::NEG_Z * 3.0];
        assert_eq!(normal_of_path(DVec3::ZERO, DVec3::X, &places), Some(DVec3::X));
        assert_eq!(normal_of_path(DVec3::ZERO, DVec3::X, &[]), None);
    }

    #[test]
    fn impossible_views_are_refused() {
        let view = SliceView { facing: Facing::X, offset: 0.0, zoom: 1.0, pan: DVec3::ZERO };
        assert_eq!(view.sound(), Some(view));
        assert_eq!(SliceView { offset: f64::NAN, ..view }.sound(), None);
        assert_eq!(SliceView { zoom: 1e9, ..view }.sound().unwrap().zoom, *ZOOM.end());
        let facing = Facing::Path { point: DVec3::ZERO, normal: DVec3::ZERO };
        assert_eq!(SliceView { facing, ..view }.sound(), None);
    }
}
