//! What the shaders are given, as it lies in memory: twins of structures in WGSL, where their fields are described. A test compares the
//! places of all fields with those that naga finds.

use bytemuck::{Pod, Zeroable};

/// Declares structures and, for the test, the places of their fields.
macro_rules! layouts {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
            #[repr(C)]
            pub struct $name {
                $(pub $field: $type,)*
            }
        )*

        /// Each structure by name, with its size and the name and place of each field.
        #[cfg(test)]
        fn all() -> Vec<(&'static str, usize, Vec<(&'static str, usize)>)> {
            vec![$(
                (
                    stringify!($name),
                    size_of::<$name>(),
                    vec![$((stringify!($field), std::mem::offset_of!($name, $field)),)*],
                ),
            )*]
        }
    };
}

layouts! {
    /// `render/gpu/scene.wgsl`
    Scene {
        root: u32,
        triangle_count: u32,
        mask: u32,
        pairs_of_media: u32,
        bounds_center: [f32; 3],
        bounds_radius: f32,
        address_of_primitive: u32,
        divided_faces: u32,
        cells: u32,
        asked: u32,
        members: u32,
        coincident: u32,
        coincident_planes: u32,
        opaque_planes: u32,
        emitter_count: u32,
        world_is_vacuum: u32,
        texels: u32,
        columns: u32,
        rows: u32,
        row_shares: u32,
        guide: u32,
        cuts_per_row: u32,
        image_size: [u32; 2],
        rotation: [f32; 2],
        zenith: [f32; 3],
        image_scale: f32,
        horizon: [f32; 3],
        first_sun: u32,
        nadir: [f32; 3],
        linear_light: u32,
    }

    /// `render/gpu/scene.wgsl`
    Image {
        position: [f32; 3],
        aperture_radius: f32,
        forward: [f32; 3],
        focus_distance: f32,
        right: [f32; 3],
        scale: f32,
        up: [f32; 3],
        start_medium: u32,
        half_size: [f32; 2],
        width: u32,
        seed_hash: u32,
        first_row: u32,
        row_count: u32,
        sample_count: u32,
        samples_before: u32,
        first_sample: u32,
        last_sample: u32,
        has_ranges: u32,
        max_depth: u32,
        is_start: u32,
        most_steps: u32,
        first_place: u32,
        path_count: u32,
        list_in: u32,
        list_out: u32,
        pad0: u32,
        pad1: u32,
    }

    /// `transport/path.wgsl`
    Path {
        origin: [f32; 3],
        sample: u32,
        direction: [f32; 3],
        leaves: u32,
        beta: [f32; 3],
        t_min: f32,
        radiance: [f32; 3],
        after: u32,
        last_position: [f32; 3],
        last_pdf: f32,
        medium: u32,
        segment: u32,
        radiance_scale: f32,
        roulette_below: f32,
        has_scattered: u32,
        pad0: u32,
        pad1: u32,
        pad2: u32,
    }

    /// `render/gpu/film.wgsl`
    PixelSums {
        radiance: [f32; 3],
        count: u32,
        squares: [f32; 3],
        segments: u32,
    }

    /// `geometry/search.wgsl`
    Node {
        min0: [f32; 3],
        child0: u32,
        max0: [f32; 3],
        child1: u32,
        min1: [f32; 3],
        pad0: u32,
        max1: [f32; 3],
        pad1: u32,
    }

    /// `geometry/triangle.wgsl`
    Triangle {
        a: [f32; 3],
        primitive: u32,
        b: [f32; 3],
        object: u32,
        c: [f32; 3],
        pad: u32,
    }

    /// `geometry/surface.wgsl`
    Face {
        normal: [f32; 3],
        object: u32,
    }

    /// `geometry/surface.wgsl`
    CornerNormals {
        a: [f32; 3],
        pad0: u32,
        b: [f32; 3],
        pad1: u32,
        c: [f32; 3],
        pad2: u32,
    }

    /// `geometry/sphere.wgsl`
    Sphere {
        center: [f32; 3],
        radius: f32,
    }

    /// `scene/scene.wgsl`
    Object {
        kind: u32,
        medium: u32,
        priority: i32,
        is_smooth: u32,
        reach: f32,
        emitter: u32,
        sphere: u32,
        outside: u32,
        color: [f32; 3],
        is_varied: u32,
        other_color: [f32; 3],
        pad0: u32,
        checker_origin: [f32; 3],
        texture: u32,
        u_axis: [f32; 3],
        pad2: u32,
        v_axis: [f32; 3],
        pad3: u32,
    }

    /// `scene/scene.wgsl`
    Medium {
        absorption: [f32; 3],
        pad0: u32,
        ior_minus_one: [f32; 2],
        pad1: [u32; 2],
    }

    /// `optics/fresnel.wgsl`
    Interface {
        eta: f32,
        inverse_eta: f32,
        e: f32,
        radiance_factor: f32,
    }

    /// `scene/lights/area.wgsl`
    Emitter {
        object: u32,
        sphere: u32,
        first: u32,
        triangle_count: u32,
        probability: f32,
        cumulative: f32,
        area: f32,
        kind: u32,
        position: [f32; 3],
        inner: f32,
        axis: [f32; 3],
        outer: f32,
        color: [f32; 3],
        is_two_sided: u32,
        next_sun: u32,
        pad0: u32,
        pad1: u32,
        pad2: u32,
    }
}

#[cfg(test)]
mod tests {
    use wgpu::naga;

    use super::*;
    use crate::render::gpu::shader::Variant;

    /// Problems of a structure's layout here against that in a module.
    fn differences(module: &naga::Module, name: &str, size: usize, fields: &[(&str, usize)]) -> Vec<String> {
        let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
        let Some((_, naga::Type { inner: naga::TypeInner::Struct { members, span }, .. })) = found else {
            return vec![format!("{name} is no structure in WGSL")];
        };
        let here: Vec<(String, usize)> = fields.iter().map(|(field, at)| ((*field).to_owned(), *at)).collect();
        let there: Vec<(String, usize)> =
            members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset as usize)).collect();
        let mut problems = Vec::new();
        if here != there {
            problems.push(format!("{name}: {here:?} here, {there:?} in WGSL"));
        }
        if size != *span as usize {
            problems.push(format!("{name}: {size} bytes here, {span} in WGSL"));
        }
        problems
    }

    #[test]
    fn structures_lie_in_memory_as_the_shaders_read_them() {
        let module = naga::front::wgsl::parse_str(&Variant::with_everything().source()).unwrap();
        let problems: Vec<String> =
            all().iter().flat_map(|(name, size, fields)| differences(&module, name, *size, fields)).collect();
        assert_eq!(problems, Vec::<String>::new());
    }

    #[test]
    fn a_field_that_is_moved_renamed_or_too_large_is_found() {
        let source = Variant::with_everything().source();
        for (from, to) in [
            ("    pad3: u32,", "    pad3: vec4u,"),
            ("    other_color: vec3f,\n    pad0: u32,", "    other_color: vec3f,\n    unused: u32,"),
            ("    texture: u32,\n    u_axis: vec3f,", "    u_axis: vec3f,\n    texture: u32,"),
        ] {
            assert_eq!(source.matches(from).count(), 1, "{from}");
            // Whoever reads the renamed field reads it by its new name.
            let mut edited = source.replace(from, to);
            if to.contains("shines") {
                edited = edited.replace("].emitter", "].shines");
            }
            let module = naga::front::wgsl::parse_str(&edited).unwrap();
            let layouts = all();
            let (name, size, fields) = layouts.iter().find(|(name, ..)| *name == "Object").unwrap();
            assert!(!differences(&module, name, *size, fields).is_empty(), "{to}");
        }
    }
}
