use std::mem::{align_of, offset_of, size_of};

use bytemuck::cast_slice;

use super::*;
use crate::formats::{self, builtin};
use crate::rectify::InterfaceTable;
use crate::rectify::asked::answer_anew;
use crate::rectify::random::Random;
use crate::rectify::subjects::{primitives_of, subjects};
use crate::scene::compile::compile;

/// Two boxes that share a part of a face, an opaque plate on a part of another face, a ball that crosses both boxes and a lamp that crosses one.
const COINCIDENT: &str = r#"
refractor = [
    { name = "left", medium = "glass", shape = { box = { min = [-1, -1, -1], max = [0, 1, 1] } } },
    { name = "right", medium = "water", shape = { box = { min = [0, -0.5, -0.5], max = [1, 0.5, 0.5] } } },
    { name = "ball", medium = "ice", shape = { sphere = { center = [0.05, 0.4, 0.1], radius = 0.3 } } },
]
solid = [
    { name = "plate", color = [0.5, 0.5, 0.5], shape = { quad = { center = [-0.5, -1, 0], edge_u = [0.6, 0, 0], edge_v = [0, 0, 0.7] } } },
]
light = [
    { name = "lamp", radiance = [1, 1, 1], shape = { sphere = { center = [-0.1, -0.5, 0.9], radius = 0.2 } } },
]
"#;

/// A plate that ten shells cross so close to each other that one cell meets all.
fn shells() -> String {
    let mut text = String::from("refractor = [\n");
    text += "{ name = \"plate\", medium = \"glass\", shape = { box = { min = [-2, -1, -2], max = [2, 0, 2] } } },\n";
    for k in 0..10 {
        let radius = 1.0 + 0.001 * f64::from(k);
        let medium = if k % 2 == 0 { "ice" } else { "water" };
        text += &format!(
            "{{ name = \"shell {k}\", medium = \"{medium}\", shape = {{ sphere = {{ center = [0, 0, 0], radius = {radius} }} }} }},\n"
        );
    }
    text + "]\n"
}

fn scene_of(objects: &str) -> Scene {
    let text = format!(
        "{objects}\ncamera = {{ position = [0, 0, 9], target = [0, 0, 0] }}\n\
        medium = [{{ name = \"glass\", ior = 1.5 }}, {{ name = \"water\", ior = 1.33 }}, {{ name = \"ice\", ior = 1.31 }}]\n"
    );
    compile(&formats::parse(&text, "scene.toml".as_ref(), &formats::Disk).unwrap(), None).unwrap()
}

fn built_in(name: &str) -> Scene {
    compile(&formats::open(name).unwrap(), None).unwrap()
}

/// Asserts that a record consists of these words, in this order, and of nothing else.
macro_rules! assert_words {
    ($record:ty: $($field:ident),*) => {
        let offsets = [$(offset_of!($record, $field)),*];
        assert!(offsets.iter().enumerate().all(|(word, offset)| *offset == 4 * word), "{offsets:?}");
        assert_eq!((size_of::<$record>(), align_of::<$record>()), (4 * offsets.len(), 4));
    };
}

#[test]
fn records_are_words_without_padding() {
    assert_words!(FaceRecord: root, group);
    assert_words!(NodeRecord: kind, index);
    assert_words!(AskedRecord: first_answer, first_member, member_count, first_opaque, opaque_count);
    assert_words!(MemberRecord: refractor, first_coincident, coincident_count);
    assert_words!(CoincidentRecord: primitive, is_same);
    assert_words!(Answer: outside, inside);
    let memberships = [Membership::Out, Membership::In, Membership::InnerOnly, Membership::OuterOnly];
    assert_eq!(memberships.map(|membership| membership as u32), [0, 1, 2, 3]);
}

/// A division into four parts by hand, and points in each.
#[test]
fn points_are_found_in_their_cells() {
    let node = |kind, index| NodeRecord { kind, index };
    let nodes = vec![node(0, 1), node(1, 3), node(KNOWN, 2), node(KNOWN, 3), node(ASKED, 4)];
    let layout = FlatLayout { nodes, ..FlatLayout::default() };
    // Corners A, B, C; the first cut halves AB at M, the second, in A M C, halves MC at N.
    assert_eq!(layout.descend(0, [0.1, 0.8, 0.1]), node(KNOWN, 2));
    // 0.8 A + 0.1 B + 0.1 C = 0.7 A + 0.2 M + 0.1 C: nearer to M than to C.
    assert_eq!(layout.descend(0, [0.8, 0.1, 0.1]), node(KNOWN, 3));
    assert_eq!(layout.descend(0, [0.3, 0.05, 0.65]), node(ASKED, 4));
}

#[test]
fn every_index_is_in_range() {
    let built_in = builtin::all().iter().map(|scene| (scene.name, built_in(scene.name)));
    for (name, scene) in built_in.chain([("coincident", scene_of(COINCIDENT)), ("shells", scene_of(&shells()))]) {
        let table = InterfaceTable::new(&scene);
        let FlatTable { layout, answers } = table.flat();
        let media = scene.media.len() as u32;
        assert!(answers.iter().all(|a| a.is_masked() || (a.outside.0 < media && a.inside.0 < media)), "{name}");
        assert_eq!(layout.address_of_object.len(), scene.objects.len(), "{name}");
        let primitives = (scene.geometry.triangle_count() + scene.geometry.sphere_count()) as u32;
        assert!([0, primitives as usize].contains(&layout.address_of_primitive.len()), "{name}");
        for object in subjects(&scene) {
            for primitive in primitives_of(&scene.geometry, object) {
                let address = layout.address(object, primitive);
                let (at, length) = if address & DIVIDED == 0 {
                    (address, answers.len())
                } else {
                    (address & !DIVIDED, layout.faces.len())
                };
                assert!((at as usize) < length, "{name}, {primitive}");
                if address & DIVIDED != 0 {
                    let roots = if scene.geometry.sphere(primitive).is_some() { 8 } else { 1 };
                    assert!((layout.faces[at as usize].root + roots) as usize <= layout.nodes.len(), "{name}");
                }
            }
        }
        for (number, node) in layout.nodes.iter().enumerate() {
            let index = node.index as usize;
            match node.kind {
                // Downwards, so that every descent ends.
                0..=2 => assert!(index > number && index + 1 < layout.nodes.len(), "{name}"),
                KNOWN => assert!(index < answers.len(), "{name}"),
                ASKED => assert!(index < layout.asked.len(), "{name}"),
                kind => panic!("{name}: {kind}"),
            }
        }
        // Blocks follow each other without gaps and end where the answers do.
        let mut next: Option<u32> = None;
        for asked in &layout.asked {
            assert!((asked.first_member + asked.member_count) as usize <= layout.members.len(), "{name}");
            assert!((asked.first_opaque + asked.opaque_count) as usize <= layout.opaque.len(), "{name}");
            if asked.first_answer != NOT_LISTED {
                assert!(next.is_none_or(|next| next == asked.first_answer), "{name}");
                let members = &layout.members[span(asked.first_member, asked.member_count)];
                let combinations = members.iter().map(|m| if m.coincident_count == 0 { 2 } else { 4 }).product::<u32>();
                next = Some(asked.first_answer + combinations);
            }
        }
        assert!(next.is_none_or(|next| next as usize == answers.len()), "{name}");
        let unlisted = layout.asked.iter().filter(|asked| asked.first_answer == NOT_LISTED).count();
        assert_eq!(unlisted, layout.unlisted as usize, "{name}");
        assert_eq!(unlisted > 0, name == "shells", "{name}");
        for member in &layout.members {
            assert!(scene.is_refractor(ObjectId(member.refractor)), "{name}");
            assert!((member.first_coincident + member.coincident_count) as usize <= layout.coincident.len(), "{name}");
        }
        assert!(layout.coincident.iter().all(|c| c.primitive < primitives && c.is_same <= 1), "{name}");
        assert!(layout.opaque.iter().all(|&primitive| primitive < primitives), "{name}");
    }
}

/// The arrays as words, and a reader that follows the head of `flat.rs` and nothing else.
struct Words<'a> {
    address_of_object: &'a [u32],
    address_of_primitive: &'a [u32],
    faces: &'a [u32],
    nodes: &'a [u32],
    asked: &'a [u32],
    members: &'a [u32],
    coincident: &'a [u32],
    opaque: &'a [u32],
    answers: &'a [u32],
}

/// What was hit, and what geometry says about it.
struct Hit<'a> {
    object: u32,
    primitive: u32,
    /// `None` on a triangle.
    normal_of_sphere: Option<[f64; 3]>,
    corner_weights: [f64; 3],
    covers: &'a dyn Fn(u32) -> bool,
    contains: &'a dyn Fn(u32) -> bool,
}

const SKIPPED: [u32; 2] = [0xffff_ffff; 2];

impl Words<'_> {
    /// The media outside and inside; `None` if the answer is not listed.
    fn read(&self, hit: &Hit<'_>) -> Option<[u32; 2]> {
        let answer = |at: u32| Some([self.answers[2 * at as usize], self.answers[2 * at as usize + 1]]);
        let mut address = self.address_of_object[hit.object as usize];
        if address == 0xffff_ffff {
            address = self.address_of_primitive[hit.primitive as usize];
        }
        if address < 0x8000_0000 {
            return answer(address);
        }
        let mut node = self.faces[2 * (address - 0x8000_0000) as usize];
        let mut weights = hit.corner_weights;
        if let Some(normal) = hit.normal_of_sphere {
            for (bit, n) in normal.into_iter().enumerate() {
                node += if n < 0.0 { 1 << bit } else { 0 };
                weights[bit] = n.abs();
            }
        }
        let index = loop {
            let (kind, index) = (self.nodes[2 * node as usize], self.nodes[2 * node as usize + 1]);
            match kind {
                3 => return answer(index),
                4 => break 5 * index as usize,
                _ => {}
            }
            let a = kind as usize;
            let b = [1, 2, 0][a];
            let (wa, wb) = (weights[a], weights[b]);
            if wa >= wb {
                weights[a] = wa - wb;
                weights[b] = 2.0 * wb;
                node = index;
            } else {
                weights[a] = 2.0 * wa;
                weights[b] = wb - wa;
                node = index + 1;
            }
        };
        let &[first_answer, first_member, member_count, first_opaque, opaque_count] = &self.asked[index..index + 5]
        else {
            unreachable!("five words")
        };
        if first_answer == 0xffff_ffff {
            return None;
        }
        if (first_opaque..first_opaque + opaque_count).any(|k| (hit.covers)(self.opaque[k as usize])) {
            return Some(SKIPPED);
        }
        let (mut at, mut place_value) = (first_answer, 1);
        for member in first_member..first_member + member_count {
            let at_member = 3 * member as usize;
            let (refractor, first, count) =
                (self.members[at_member], self.members[at_member + 1], self.members[at_member + 2]);
            let covering = (first..first + count).map(|k| 2 * k as usize).find(|&k| (hit.covers)(self.coincident[k]));
            let digit = match covering {
                Some(k) if self.coincident[k] < hit.primitive => return Some(SKIPPED),
                Some(k) => [3, 2][self.coincident[k + 1] as usize],
                None => u32::from((hit.contains)(refractor)),
            };
            at += digit * place_value;
            place_value *= if count > 0 { 4 } else { 2 };
        }
        answer(at)
    }
}

/// Visits points of divided faces, and some others.
fn for_each_point(scene: &Scene, layout: &FlatLayout, mut visit: impl FnMut(ObjectId, &SurfacePoint, [f64; 2])) {
    const MOST: usize = 20_000;
    let geometry = &*scene.geometry;
    let mut random = Random::new(7);
    let of_each = (MOST / layout.faces.len().max(1)).clamp(1, 400);
    for object in subjects(scene) {
        for primitive in primitives_of(geometry, object) {
            let points = if layout.address(object, primitive) & DIVIDED == 0 { 1 } else { of_each };
            for _ in 0..points {
                // The square is folded into the triangle, as the geometry does.
                let u = [random.next(), random.next()];
                let Some(point) = geometry.sample_primitive(primitive, u) else { break };
                let barycentric = if u[0] + u[1] > 1.0 { u.map(|u| 1.0 - u) } else { u };
                visit(object, &point, barycentric);
            }
        }
    }
}

/// Points of `scene` at which the table looks an answer up in a divided face, skips the crossing, and does not list the answer.
fn compare_readers(scene: &Scene) -> [usize; 3] {
    let geometry = &*scene.geometry;
    let table = InterfaceTable::new(scene);
    let flat = table.flat();
    let layout = &*flat.layout;
    let words = Words {
        address_of_object: &layout.address_of_object,
        address_of_primitive: &layout.address_of_primitive,
        faces: cast_slice(&layout.faces),
        nodes: cast_slice(&layout.nodes),
        asked: cast_slice(&layout.asked),
        members: cast_slice(&layout.members),
        coincident: cast_slice(&layout.coincident),
        opaque: &layout.opaque,
        answers: cast_slice(&flat.answers),
    };
    let is_simple = |member: &MemberRecord| !scene.object(ObjectId(member.refractor)).may_contain_itself();
    assert!(layout.members.iter().all(is_simple), "the reader knows no refractors of several parts");
    let [mut divided, mut skipped, mut unlisted] = [0; 3];
    for_each_point(scene, layout, |object, point, [u, v]| {
        let covers = |primitive: u32| {
            let tolerance = Tolerance::between(geometry, object.0, geometry.object_of(primitive));
            Face::of(geometry, primitive).cover(&[point.position], tolerance) == Cover::All
        };
        let contains = |refractor: u32| is_inside(scene, ObjectId(refractor), point);
        let hit = Hit {
            object: object.0,
            primitive: point.primitive,
            normal_of_sphere: geometry.sphere(point.primitive).map(|_| point.normal.to_array()),
            corner_weights: [1.0 - u - v, u, v],
            covers: &covers,
            contains: &contains,
        };
        let read = words.read(&hit);
        divided += usize::from(table.is_mixed(object, point.primitive));
        skipped += usize::from(read == Some(SKIPPED));
        match flat.look(scene, object, point, [u, v]) {
            Lookup::Answer(answer) => assert_eq!(read, Some([answer.outside.0, answer.inside.0]), "{point:?}"),
            Lookup::Unlisted(_) => {
                assert_eq!(read, None);
                assert_eq!(table.look(scene, object, point, [u, v]), answer_anew(scene, point), "{point:?}");
                unlisted += 1;
            }
        }
    });
    [divided, skipped, unlisted]
}

#[test]
fn another_reader_of_the_same_words_finds_the_same() {
    for name in ["half-submerged", "iced-water"] {
        let [divided, _, unlisted] = compare_readers(&built_in(name));
        assert!(divided > 1000 && unlisted == 0, "{name}: {divided}, {unlisted}");
    }
    let [divided, skipped, unlisted] = compare_readers(&scene_of(COINCIDENT));
    assert!(divided > 1000 && skipped > 100 && unlisted == 0, "{divided}, {skipped}, {unlisted}");
    let [divided, _, unlisted] = compare_readers(&scene_of(&shells()));
    assert!(divided > 1000 && unlisted > 5, "{divided}, {unlisted}");
}
