//! The corpus, as it is written by `tests/fuzzing.rs`: small files of each format, in the ways in which programs write them.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage};
use iorect::export::write_sums;
use iorect::render::exact::unit_exponent;
use iorect::render::{Film, ImageSettings, Partial, Recipe, RenderTask};
use iorect::scene::camera::Camera;
use iorect::tracking::Mode;
use iorect::tracking::prepare;

const SHAPES: &str = r#"name = "shapes"
[camera]
position = [0.0, 0.5, 6.0]
target = [0.0, 0.0, 0.0]
vertical_fov = 30.0
aperture_radius = 0.01
focus_distance = 5.5
[world]
ior = 1.1
absorption = [0.1, 0.0, 0.0]
[environment]
gradient = { zenith = [0.3, 0.5, 1.0], horizon = [1.0, 0.9, 0.8], nadir = [0.1, 0.2, 0.1] }
[[medium]]
name = "glass"
ior = { cauchy = [1.5, 0.004, 0.0] }
[[medium]]
name = "water"
ior = { catalog = "water" }
absorption = [0.3, 0.1, 0.2]
[[refractor]]
name = "shell"
medium = "glass"
shape = { lathe = { profile = [[0.0, 0.0], [1.0, 0.5], [0.0, 1.0]], segments = 12 } }
priority = -3
smooth = true
[[refractor]]
name = "middle"
medium = "water"
shape = { torus = { center = [0, 0, 0], major = 1.0, minor = 0.25, segments = 8, rings = 6 } }
transform = { scale = 2, rotate = [10, 20, 30], translate = [1e-3, 0, -2] }
[[solid]]
name = "floor"
shape = { quad = { center = [0, -1.2, 0], edge_u = [0, 0, 8], edge_v = [8, 0, 0] } }
checker = { a = [0.8, 0.8, 0.8], b = [0.1, 0.2, 0.4], size = 0.5 }
[[light]]
name = "lamp"
visible = false
shape = { sphere = { center = [1.0, 2.0, 1.0], radius = 0.2 } }
radiance = [40.0, 38.0, 34.0]
"#;

const NOTATIONS: &str = r#"# The same things in other notations of TOML.
camera = { position = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0] }
environment.color = [0.5, 0.5, 0.5]
'medium' = [{ name = "a \"quoted\" name", ior = 1.333_0 }, { name = 'öl', ior = { sellmeier = [[1.0, 0.01], [0.2, 0.02]] } }]

[[refractor]]
name = """two
lines"""
medium = 'öl'
shape.icosphere = { center = [+0.0, -0.0, 0x10], radius = 1e0, subdivisions = 2 }
[refractor.transform]
scale = [1.0, 2.0, -3.0]

[[refractor]]
name = "box"
medium = "a \"quoted\" name"
shape = { box = { min = [-1, -1, -1], max = [1, 1, 1] } }
[[solid]]
name = "post"
shape = { cylinder = { center = [0, 0, 0], radius = 0.5, height = 2, segments = 5 } }
color = [1, 0, 0.25]
mirror = true
"#;

const CUBE_OBJ: &str = "# a cube of quads\nmtllib a.mtl\no cube\n\
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\ng sides\nusemtl glass\ns 1\n\
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

const TETRAHEDRON_OBJ: &str = "v 0 0 0 1.0\r\nv 1.0e0 0 0\r\nv 0 1 0\r\nv 0 0 1\r\nvn 0 0 -1\r\nvn 0 -1 0\r\nvn -1 0 0\r\nvn 1 1 1\r\n\
vt 0 0\r\nvt 1 0\r\nf -4//1 -2//1 -3//1\r\nf 1/1/2 2/2/2 4/1/2\r\nf 1/1/3 4/2/3 3/1/3\r\nf 2//4 3//4 4//4\r\n";

const TABLE_MTL: &str = "# as programs write it\nnewmtl glass\nNs 250\nKa 1 1 1\nKd 0.8 0.8 0.8\nKe 0 0 0\nNi 1.46\nd 0.1\nillum 7\n\n\
newmtl red wine\nNi 1.34\nTf 0.5 0.1 0.1\nillum 6\nnewmtl lamp\nKe 10 9 8\nnewmtl wood\nKd 0.4 0.2 0.1\nmap_Kd oak.png\nPm 0.0\nTr 0\n";

const PLAIN_MTL: &str = "newmtl glass\r\nNi 1.7\r\nnewmtl red wine\r\nNi 1.4\r\nTf 1 1 1\r\nnewmtl lamp\r\nNi 1.2\r\nnewmtl wood\r\nNi 1.3\r\n";

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[i32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// Target, name, contents.
pub fn all() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let mut all = vec![
        ("scene", "shapes.toml", SHAPES.into()),
        ("scene", "notations.toml", NOTATIONS.into()),
        ("obj", "cube.obj", CUBE_OBJ.into()),
        ("obj", "tetrahedron.obj", TETRAHEDRON_OBJ.into()),
        ("ply", "ascii.ply", ascii_ply().into()),
        ("ply", "little.ply", binary_ply("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes)),
        ("ply", "big.ply", binary_ply("binary_big_endian", f32::to_be_bytes, i32::to_be_bytes)),
        ("gltf", "table.glb", super::gltf::binary()),
        ("gltf", "table.gltf", super::gltf::embedded(&encoded(bytes(3, 2), ImageFormat::Png))),
        ("gltf", "packed.glb", super::gltf::packed()),
        ("mtl", "table.mtl", TABLE_MTL.into()),
        ("mtl", "plain.mtl", PLAIN_MTL.into()),
        ("hdr", "runs.hdr", encoded(floats(16, 4), ImageFormat::Hdr)),
        ("hdr", "flat.hdr", flat_hdr()),
        ("exr", "image.exr", encoded(floats(6, 4), ImageFormat::OpenExr)),
        ("png", "eight_bits.png", encoded(bytes(7, 5), ImageFormat::Png)),
        ("png", "sixteen_bits.png", encoded(bytes(4, 3).into_rgba16().into(), ImageFormat::Png)),
        ("png", "grey.png", encoded(bytes(5, 3).into_luma8().into(), ImageFormat::Png)),
        ("jpeg", "color.jpg", encoded(bytes(16, 8), ImageFormat::Jpeg)),
        ("jpeg", "grey.jpg", encoded(bytes(9, 9).into_luma8().into(), ImageFormat::Jpeg)),
        ("sums", "first.exr", sums(0)),
        ("sums", "second.exr", sums(2)),
    ];
    all.extend(exr_files());
    all
}

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a tetrahedron\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ascii_ply() -> String {
    let vertices = POSITIONS.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
    ply_header("ascii") + &vertices + &FACES.map(|[a, b, c]| format!("3 {a} {b} {c}\n")).concat()
}

fn binary_ply(format: &str, float: fn(f32) -> [u8; 4], integer: fn(i32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = ply_header(format).into_bytes();
    POSITIONS.iter().flatten().for_each(|x| bytes.extend(float(*x)));
    for face in FACES {
        bytes.push(3);
        face.iter().for_each(|corner| bytes.extend(integer(*corner)));
    }
    bytes
}

fn encoded(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn floats(width: u32, height: u32) -> DynamicImage {
    Rgb32FImage::from_fn(width, height, |x, y| Rgb([0.25 * x as f32, y as f32, 1e3 / (1 + x + y) as f32])).into()
}

fn bytes(width: u32, height: u32) -> DynamicImage {
    RgbImage::from_fn(width, height, |x, y| Rgb([x as u8 * 15, y as u8 * 30, (x * y) as u8])).into()
}

/// Narrower than what may be compressed.
fn flat_hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\n# by hand\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\n".to_vec();
    (0..6).for_each(|pixel| bytes.extend([128, 64, 16 * pixel, 129]));
    bytes
}

/// Compressed in other ways, in tiles, and with half floats.
fn exr_files() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    use exr::prelude::{
        AttributeValue, Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels,
        Vec2, WritableImage, f16,
    };
    let encodings = [
        (
            "rle_lines.exr",
            Encoding { compression: Compression::RLE, blocks: Blocks::ScanLines, line_order: LineOrder::Decreasing },
        ),
        (
            "zip_tiles.exr",
            Encoding {
                compression: Compression::ZIP16,
                blocks: Blocks::Tiles(Vec2(4, 4)),
                line_order: LineOrder::Increasing,
            },
        ),
        (
            "piz_lines.exr",
            Encoding { compression: Compression::PIZ, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing },
        ),
    ];
    let mut files = Vec::new();
    for (name, encoding) in encodings {
        let half = |x: usize| f16::from_f32(x as f32 * 0.5);
        let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| (half(x), half(y), half(x * y)));
        let mut image = Image::from_layer(Layer::new((6, 5), LayerAttributes::named("picture"), encoding, channels));
        image.attributes.other.insert("note".into(), AttributeValue::Text("by a test".into()));
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        files.push(("exr", name, bytes.into_inner()));
    }
    files
}

/// Two samples of a small scene, from `first` on.
fn sums(first: u32) -> Vec<u8> {
    let description = Arc::new(
        iorect::formats::parse(SHAPES, Path::new("assets/scenes/fuzz.toml"), &iorect::formats::BuiltIn).unwrap(),
    );
    let prepared = prepare(Arc::clone(&description), None).unwrap();
    let camera = Camera::new(&description.camera).unwrap();
    let settings = ImageSettings { max_depth: Some(8), ..ImageSettings::new(Mode::Rectified, 0) };
    let unit_exponent = unit_exponent(&description);
    let mut film = Film::partial(5, 4, first, unit_exponent);
    assert!(RenderTask { prepared: &prepared, camera: &camera, settings: &settings }.pass(
        &mut film,
        2,
        &AtomicBool::new(false)
    ));
    let recipe = Recipe {
        version: "corpus".to_owned(),
        scene: description.name.clone(),
        content: description.fingerprint(),
        camera: camera.fingerprint(),
        adapter: None,
        width: film.width,
        height: film.height,
        settings,
        unit_exponent,
    };
    let file = tempfile::Builder::new().suffix(".exr").tempfile().unwrap();
    write_sums(file.path(), &Partial::of_film(film, recipe).unwrap()).unwrap();
    std::fs::read(file.path()).unwrap()
}
