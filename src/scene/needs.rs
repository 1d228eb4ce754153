//! What a scene needs from the tracer. Everything it does not need is left out of the work.

/// Worked out once per compile. Each `false` removes work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneNeeds {
    /// Some refractor may lie in another or overlap itself, or the world's IOR is not that of vacuum: without this all modes agree.
    pub nesting: bool,
    /// Some medium absorbs.
    pub absorption: bool,
    /// Two media that can meet have the same IOR: surfaces that do not bend light, which shadow rays must walk through.
    pub index_matching: bool,
    /// Interpolated normals.
    pub smooth_normals: bool,
    /// Analytic spheres.
    pub spheres: bool,
    /// Triangles.
    pub triangles: bool,
    /// Objects that emit.
    pub emitters: bool,
    /// An environment worth sampling: an image.
    pub image_environment: bool,
}

impl SceneNeeds {
    /// Nothing left out.
    pub const EVERYTHING: Self = Self {
        nesting: true,
        absorption: true,
        index_matching: true,
        smooth_normals: true,
        spheres: true,
        triangles: true,
        emitters: true,
        image_environment: true,
    };

    /// The same with one need more, by its name; any other name changes nothing.
    pub fn with(mut self, need: &str) -> Self {
        match need {
            "nesting" => self.nesting = true,
            "absorption" => self.absorption = true,
            "index_matching" => self.index_matching = true,
            "smooth_normals" => self.smooth_normals = true,
            "spheres" => self.spheres = true,
            "triangles" => self.triangles = true,
            "emitters" => self.emitters = true,
            "image_environment" => self.image_environment = true,
            _ => {}
        }
        self
    }

    /// Each need by name, with whether the scene has it.
    pub fn named(&self) -> [(&'static str, bool); 8] {
        [
            ("nesting", self.nesting),
            ("absorption", self.absorption),
            ("index_matching", self.index_matching),
            ("smooth_normals", self.smooth_normals),
            ("spheres", self.spheres),
            ("triangles", self.triangles),
            ("emitters", self.emitters),
            ("image_environment", self.image_environment),
        ]
    }

    /// Names of what is left out.
    pub fn left_out(&self) -> Vec<&'static str> {
        self.named().into_iter().filter(|(_, needed)| !needed).map(|(name, _)| name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needs_are_put_back_by_name() {
        let nothing = SceneNeeds {
            nesting: false,
            absorption: false,
            index_matching: false,
            smooth_normals: false,
            spheres: false,
            triangles: false,
            emitters: false,
            image_environment: false,
        };
        let names = SceneNeeds::EVERYTHING.named().map(|(name, _)| name);
        for name in names {
            let left_out: Vec<_> = names.into_iter().filter(|other| *other != name).collect();
            assert_eq!(nothing.with(name).left_out(), left_out);
        }
        assert_eq!(names.into_iter().fold(nothing, SceneNeeds::with), SceneNeeds::EVERYTHING);
        assert_eq!(nothing.with("colour"), nothing);
    }
}
