// What the shaders are given. The layouts are those of `layout.rs`.

struct Scene {
    root: u32,
    triangle_count: u32,
    /// Where in `answers` the bits of masked primitives begin.
    mask: u32,
    /// Media of which all pairs are kept in `interfaces`; 0: none.
    pairs_of_media: u32,
    bounds_center: vec3f,
    /// 0: there is nothing.
    bounds_radius: f32,
    // Where in `table` its arrays begin: see `rectify/flat.wgsl`.
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
    // Where in `light_tables` the environment's begin.
    texels: u32,
    columns: u32,
    rows: u32,
    row_shares: u32,
    guide: u32,
    cuts_per_row: u32,
    image_size: vec2u,
    /// sin and cos of the environment's rotation about +y.
    rotation: vec2f,
    zenith: vec3f,
    image_scale: f32,
    /// Of a constant environment its radiance.
    horizon: vec3f,
    /// The first emitter from afar that has an extent, or `NOTHING`.
    first_sun: u32,
    nadir: vec3f,
    /// Where in `light_tables` linear light by code value of sRGB begins.
    linear_light: u32,
}

/// An image, and the part of it that one dispatch renders.
struct Image {
    position: vec3f,
    aperture_radius: f32,
    forward: vec3f,
    focus_distance: f32,
    right: vec3f,
    /// Height of a pixel at distance 1.
    scale: f32,
    up: vec3f,
    start_medium: u32,
    half_size: vec2f,
    width: u32,
    seed_hash: u32,
    first_row: u32,
    row_count: u32,
    /// Samples to take of each pixel, and how many of those before them are taken.
    sample_count: u32,
    samples_before: u32,
    /// The samples of every pixel, from the first up to but without the last; unless each has its own, in `ranges`.
    first_sample: u32,
    last_sample: u32,
    has_ranges: u32,
    max_depth: u32,
    /// Whether paths of `row_count` rows are started, or `path_count` that were interrupted go on.
    is_start: u32,
    /// After so many steps of a thread its path is interrupted.
    most_steps: u32,
    /// Place in the band, whose first row is `first_row`, of the first path that is started.
    first_place: u32,
    path_count: u32,
    /// Where in `lists` the paths that go on are found, and where those that are interrupted are put.
    list_in: u32,
    list_out: u32,
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> image: Image;
@group(0) @binding(1) var<uniform> scene: Scene;
@group(0) @binding(2) var<storage, read> nodes: array<Node>;
@group(0) @binding(3) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(4) var<storage, read> faces: array<Face>;
@group(0) @binding(5) var<storage, read> corner_normals: array<CornerNormals>;
@group(0) @binding(6) var<storage, read> spheres: array<Sphere>;
@group(0) @binding(7) var<storage, read> table: array<u32>;
@group(0) @binding(8) var<storage, read> answers: array<u32>;
@group(0) @binding(9) var<storage, read> objects: array<Object>;
@group(0) @binding(10) var<storage, read> media: array<Medium>;
@group(0) @binding(11) var<storage, read> interfaces: array<Interface>;
@group(0) @binding(12) var<storage, read> emitters: array<Emitter>;
@group(0) @binding(13) var<storage, read> light_tables: array<u32>;
