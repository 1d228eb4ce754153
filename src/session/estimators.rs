//! The estimator of each scene, chosen once and again when its lights change.

use std::sync::Arc;

use super::Request;
use crate::render::{Estimator, EstimatorChoice, ImageSettings, choose_estimator};
use crate::scene::Description;
use crate::scene::camera::Camera;
use crate::scene::description::Kind;
use crate::tracking::Prepared;

/// What was chosen last.
#[derive(Debug, Default)]
pub(super) struct Estimators {
    automatic: Option<(Arc<Description>, Estimator)>,
}

impl Estimators {
    /// How the films of a request are rendered. What is chosen automatically holds while the scene keeps its lights: a caustic that comes and
    /// goes with each edit must not change the noise of the image with it.
    pub(super) fn settings(&mut self, request: &Request, prepared: &Prepared, camera: &Camera) -> ImageSettings {
        let estimator = match request.estimator {
            EstimatorChoice::Auto => self.automatic(prepared, camera),
            asked => choose_estimator(asked, prepared, camera),
        };
        let splits = if estimator == Estimator::Path { request.settings.splits } else { 0 };
        ImageSettings { estimator, splits, ..request.settings }
    }

    fn automatic(&mut self, prepared: &Prepared, camera: &Camera) -> Estimator {
        let description = &prepared.description;
        let known = self.automatic.as_ref().filter(|(before, _)| {
            description.is_of(before.source.as_ref())
                && before.objects.of(Kind::Light) == description.objects.of(Kind::Light)
        });
        if let Some((_, estimator)) = known {
            return *estimator;
        }
        let estimator = choose_estimator(EstimatorChoice::Auto, prepared, camera);
        self.automatic = Some((Arc::clone(description), estimator));
        estimator
    }
}
