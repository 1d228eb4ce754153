//! What is read of a glTF file's JSON, by the names of the specification (glTF 2.0, section 5). What is left out has its default there;
//! indices may be out of range.

use std::collections::HashMap;

use serde::Deserialize;
use serde::de::IgnoredAny;

macro_rules! tables {
    ($($(#[$doc:meta])* struct $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Default, Deserialize)]
            #[serde(rename_all = "camelCase", default)]
            pub struct $name {
                $($(#[$field_doc])* pub $field: $type,)*
            }
        )*
    };
}

tables! {
    struct Root {
        asset: Asset,
        scene: Option<usize>,
        scenes: Vec<Scene>,
        nodes: Vec<Node>,
        meshes: Vec<Mesh>,
        accessors: Vec<Accessor>,
        buffer_views: Vec<BufferView>,
        buffers: Vec<Buffer>,
        materials: Vec<Material>,
        textures: Vec<Texture>,
        samplers: Vec<Sampler>,
        images: Vec<Image>,
        cameras: Vec<Camera>,
        animations: Vec<IgnoredAny>,
        extensions: RootExtensions,
        extensions_required: Vec<String>,
        extensions_used: Vec<String>,
    }

    struct Asset {
        version: String,
        generator: String,
    }

    struct RootExtensions {
        #[serde(rename = "KHR_lights_punctual")]
        lights: Lights,
    }

    struct Lights {
        lights: Vec<Light>,
    }

    struct Light {
        name: String,
        #[serde(rename = "type")]
        kind: String,
        color: Option<[f64; 3]>,
        intensity: Option<f64>,
        range: Option<f64>,
        spot: Spot,
    }

    struct Spot {
        inner_cone_angle: f64,
        outer_cone_angle: Option<f64>,
    }

    struct Scene {
        nodes: Vec<usize>,
    }

    struct Node {
        name: String,
        children: Vec<usize>,
        mesh: Option<usize>,
        camera: Option<usize>,
        skin: Option<usize>,
        /// By columns.
        matrix: Option<[f64; 16]>,
        translation: Option<[f64; 3]>,
        /// x, y, z, w.
        rotation: Option<[f64; 4]>,
        scale: Option<[f64; 3]>,
        extensions: NodeExtensions,
    }

    struct NodeExtensions {
        #[serde(rename = "KHR_lights_punctual")]
        light: Option<LightReference>,
        #[serde(rename = "EXT_mesh_gpu_instancing")]
        instancing: Option<IgnoredAny>,
    }

    struct LightReference {
        light: usize,
    }

    struct Mesh {
        name: String,
        primitives: Vec<Primitive>,
    }

    struct Primitive {
        attributes: HashMap<String, usize>,
        indices: Option<usize>,
        material: Option<usize>,
        mode: Option<u32>,
        targets: Vec<IgnoredAny>,
        extensions: HashMap<String, IgnoredAny>,
    }

    struct Accessor {
        buffer_view: Option<usize>,
        byte_offset: u64,
        component_type: u32,
        normalized: bool,
        count: u64,
        #[serde(rename = "type")]
        kind: String,
        sparse: Option<Sparse>,
    }

    struct Sparse {
        count: u64,
        indices: SparsePart,
        values: SparsePart,
    }

    struct SparsePart {
        buffer_view: usize,
        byte_offset: u64,
        component_type: u32,
    }

    struct BufferView {
        buffer: usize,
        byte_offset: u64,
        byte_length: u64,
        byte_stride: Option<u64>,
    }

    struct Buffer {
        uri: Option<String>,
        byte_length: u64,
    }

    struct Image {
        uri: Option<String>,
        buffer_view: Option<usize>,
    }

    struct Texture {
        source: Option<usize>,
        sampler: Option<usize>,
    }

    struct Sampler {
        wrap_s: Option<u32>,
        wrap_t: Option<u32>,
    }

    struct TextureReference {
        index: usize,
        tex_coord: usize,
        extensions: TextureExtensions,
    }

    struct TextureExtensions {
        #[serde(rename = "KHR_texture_transform")]
        transform: Option<TextureTransform>,
    }

    struct TextureTransform {
        offset: [f64; 2],
        /// Counter-clockwise, in radians.
        rotation: f64,
        scale: Option<[f64; 2]>,
        tex_coord: Option<usize>,
    }

    struct Material {
        name: String,
        pbr_metallic_roughness: Pbr,
        emissive_factor: [f64; 3],
        emissive_texture: Option<TextureReference>,
        normal_texture: Option<TextureReference>,
        alpha_mode: String,
        double_sided: bool,
        extensions: MaterialExtensions,
    }

    struct Pbr {
        base_color_factor: Option<[f64; 4]>,
        base_color_texture: Option<TextureReference>,
        metallic_factor: Option<f64>,
        roughness_factor: Option<f64>,
        metallic_roughness_texture: Option<TextureReference>,
    }

    struct MaterialExtensions {
        #[serde(rename = "KHR_materials_ior")]
        ior: Option<IorExtension>,
        #[serde(rename = "KHR_materials_transmission")]
        transmission: Option<Transmission>,
        #[serde(rename = "KHR_materials_volume")]
        volume: Option<Volume>,
        #[serde(rename = "KHR_materials_dispersion")]
        dispersion: Option<Dispersion>,
        #[serde(rename = "KHR_materials_emissive_strength")]
        emissive_strength: Option<EmissiveStrength>,
        #[serde(rename = "KHR_materials_specular")]
        specular: Option<Specular>,
        #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
        specular_glossiness: Option<SpecularGlossiness>,
        #[serde(flatten)]
        others: HashMap<String, IgnoredAny>,
    }

    struct IorExtension {
        ior: Option<f64>,
    }

    struct Transmission {
        transmission_factor: f64,
        transmission_texture: Option<TextureReference>,
    }

    struct Volume {
        thickness_factor: f64,
        attenuation_distance: Option<f64>,
        attenuation_color: Option<[f64; 3]>,
    }

    struct Dispersion {
        dispersion: f64,
    }

    struct EmissiveStrength {
        emissive_strength: Option<f64>,
    }

    struct Specular {
        specular_factor: Option<f64>,
        specular_color_factor: Option<[f64; 3]>,
    }

    struct SpecularGlossiness {
        diffuse_factor: Option<[f64; 4]>,
        diffuse_texture: Option<TextureReference>,
    }

    struct Camera {
        #[serde(rename = "type")]
        kind: String,
        perspective: Option<Perspective>,
    }

    struct Perspective {
        yfov: f64,
    }
}
