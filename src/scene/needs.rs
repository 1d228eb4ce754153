//! What a scene needs from the tracer. Everything it does not need is left out of the work.

/// Declares [`SceneNeeds`], each need with its name.
macro_rules! needs {
    ($($(#[$doc:meta])* $need:ident,)*) => {
        /// Worked out once per compile. Each `false` removes work.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct SceneNeeds {
            $($(#[$doc])* pub $need: bool,)*
        }

        impl SceneNeeds {
            /// Nothing left out.
            pub const EVERYTHING: Self = Self { $($need: true,)* };

            /// The same with one need more, by its name; any other name changes nothing.
            pub fn with(mut self, need: &str) -> Self {
                $(self.$need |= need == stringify!($need);)*
                self
            }

            /// Each need by name, with whether the scene has it.
            pub fn named(&self) -> [(&'static str, bool); [$(stringify!($need)),*].len()] {
                [$((stringify!($need), self.$need)),*]
            }
        }
    };
}

needs! {
    /// Some refractor may lie in another or overlap itself, or the world's IOR is not that of vacuum: without this all modes agree.
    nesting,
    /// Some medium absorbs.
    absorption,
    /// Two media that can meet have the same IOR: surfaces that do not bend light, which shadow rays must walk through.
    index_matching,
    /// Interpolated normals.
    smooth_normals,
    /// Analytic spheres.
    spheres,
    triangles,
    /// Lights other than the environment.
    emitters,
    /// An environment worth sampling: an image.
    image_environment,
    /// Images on solids.
    textures,
}

impl SceneNeeds {
    /// Names of what is left out.
    pub fn left_out(&self) -> Vec<&'static str> {
        self.named().into_iter().filter(|(_, needed)| !needed).map(|(name, _)| name).collect()
    }
}
