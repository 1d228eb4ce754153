//! `iorect render --tev`: the picture that is written is the picture that is sent.

use crate::desk::Desk;
use crate::tev_listener::Listener;

const BALL: &str = "name = \"Ball\"\n[camera]\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\n[environment]\ncolor = [1.0, 0.5, 0.25]\n[[medium]]\n\
    name = \"glass\"\nior = 1.5\nabsorption = [0.1, 0.3, 0.2]\n[[refractor]]\nname = \"ball\"\nmedium = \"glass\"\n\
    shape = { sphere = { center = [0, 0, 0], radius = 1 } }\n";

#[test]
fn what_is_written_is_sent() {
    let desk = Desk::with("ball.toml", BALL);
    let listener = Listener::open();
    desk.fine(&format!("render ball.toml --size 9x5 --spp 2 -o ball.exr --tev={}", listener.address));
    let written = image::load_from_memory(&desk.get("ball.exr")).unwrap().to_rgb32f();
    let images = listener.wait_for("the picture", |images| images.values().any(|image| image.updates > 0));
    let sent = &images["rectified – Ball"];
    assert_eq!(sent.size, [9, 5]);
    for (channel, name) in ["R", "G", "B"].iter().enumerate() {
        let floats: Vec<f32> = written.pixels().map(|pixel| pixel.0[channel]).collect();
        assert_eq!(sent.channels[*name], floats);
        assert!(floats.iter().any(|x| *x > 0.0));
    }
}

#[test]
fn where_nobody_listens_nothing_is_rendered() {
    let desk = Desk::with("ball.toml", BALL);
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let error = desk.refused(&format!("render ball.toml --size 9x5 --spp 2 -o ball.exr --tev={free}"), 1);
    assert!(error.contains("tev does not listen") && error.contains(&free.to_string()), "{error}");
}
