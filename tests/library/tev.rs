//! Pictures to tev, held against an independent reading of its protocol.

use iorect::export::Picture;
use iorect::export::tev::{PATIENCE, Tev};

use crate::tev_listener::{Image, Listener};

fn picture(width: u32, height: u32, seed: u32) -> Picture {
    let value = |i: u32| f32::from_bits(0x3000_0000 + (i.wrapping_mul(2_654_435_761).wrapping_add(seed) >> 5));
    let rgb = (0..width * height).map(|i| [value(3 * i), value(3 * i + 1), -value(3 * i + 2)]).collect();
    Picture { width, height, rgb }
}

fn holds(image: &Image, picture: &Picture) -> bool {
    image.size == [picture.width as usize, picture.height as usize]
        && ["R", "G", "B"].iter().enumerate().all(|(channel, name)| {
            let sent = picture.rgb.iter().map(|rgb| rgb[channel].to_bits());
            image.channels[*name].iter().map(|x| x.to_bits()).eq(sent)
        })
}

#[test]
fn every_float_arrives_in_its_place() {
    let listener = Listener::open();
    let mut tev = Tev::connect(&listener.address, PATIENCE).unwrap();
    // The last is sent in several packets of whole rows, the last of which is short.
    let pictures = [picture(1, 1, 1), picture(7, 3, 2), picture(5, 1_000_003, 3)];
    for (index, picture) in pictures.iter().enumerate() {
        tev.show(&format!("water − glass {index}"), picture, true).unwrap();
    }
    let images = listener.wait_for("all pictures", |images| {
        pictures
            .iter()
            .enumerate()
            .all(|(i, p)| images.get(&format!("water − glass {i}")).is_some_and(|image| holds(image, p)))
    });
    assert!(images["water − glass 2"].updates > 1 && images["water − glass 1"].updates == 1);
    // New values for an image that is there, and odd ones as they are.
    let mut other = picture(7, 3, 9);
    other.rgb[4] = [f32::NAN, f32::INFINITY, -0.0];
    tev.update("water − glass 1", &other).unwrap();
    listener.wait_for("the update", |images| holds(&images["water − glass 1"], &other));
    // An image of that name is replaced, in another size.
    let small = picture(2, 2, 5);
    tev.show("water − glass 1", &small, false).unwrap();
    listener.wait_for("the other size", |images| holds(&images["water − glass 1"], &small));
}
