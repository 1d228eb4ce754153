//! Crossings that a mode skips leave no trace in the picture: no bend, no depth, no random number, and shadow rays pass through them.

use crate::common::{add, empty, mean, ready, render, sphere, through};
use glam::DVec3;
use iorect::geometry::Ray;
use iorect::scene::description::{Description, Environment, Light, Object, Paint, Shape, Solid};
use iorect::tracking::Mode;
use iorect::transport::inspect::{Follow, VertexEvent, trace};

/// A room of water, lit and floored inside, seen through its top. All indices differ, so that no surface is matched.
fn room() -> Description {
    let mut description = empty(1.0);
    description.environment = Environment::Color([0.2; 3]);
    let (min, max) = (DVec3::new(-4.0, -1.0, -4.0), DVec3::new(4.0, 3.0, 4.0));
    add(&mut description, Shape::Box { min, max }, 1.3, 0.0);
    description.objects.refractors_mut()[0].refractor_mut().unwrap().priority = 2;
    description.objects.push(Object::new(
        "floor",
        Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 6.0, edge_v: DVec3::X * 6.0 },
        Solid::of(Paint::Color([0.7; 3])),
    ));
    description.objects.push(Object::new("lamp", sphere(DVec3::new(0.5, 2.5, 0.0), 0.2), Light::of_radiance([5.0; 3])));
    description.camera.position = DVec3::new(0.0, 9.0, 0.5);
    description.camera.vertical_fov = 20.0;
    description
}

/// Twelve balls of glass around each other between floor and lamp: 24 crossings, each way.
fn with_balls(priority: i32) -> Description {
    let mut description = room();
    for k in 0..12 {
        add(
            &mut description,
            sphere(DVec3::new(0.0, 1.1, 0.0), 1.0 - 0.05 * f64::from(k)),
            1.5 + 0.01 * f64::from(k),
            0.0,
        );
        description.objects.refractors_mut()[k as usize + 1].refractor_mut().unwrap().priority = priority;
    }
    description
}

#[test]
fn what_a_higher_priority_hides_is_not_seen() {
    let [plain, hidden, seen] = [room(), with_balls(-1), with_balls(3)].map(ready);
    assert!(!hidden.scene.needs.index_matching, "shadow rays would pass anyway");
    // A tight cap on depth shows that skipped crossings do not count.
    for max_depth in [None, Some(3)] {
        let [plain, hidden, seen] = [&plain, &hidden, &seen].map(|s| render(s, Mode::Priority, (40, 40), 4, max_depth));
        assert!(mean(&plain).0 > 0.05);
        assert_eq!(plain.sums, hidden.sums);
        assert_eq!((plain.events.total(), hidden.events.total()), (0, 0));
        assert_ne!(plain.sums, seen.sums);
    }
    // Nor with all work done that could be left out.
    let hidden_again = iorect::tracking::Prepared {
        scene: std::sync::Arc::new(iorect::scene::Scene {
            needs: iorect::scene::SceneNeeds::EVERYTHING.without_impossible(&hidden.scene),
            ..(*hidden.scene).clone()
        }),
        ..hidden.clone()
    };
    let [a, b] = [&hidden, &hidden_again].map(|s| render(s, Mode::Priority, (40, 40), 4, None).sums);
    assert_eq!(a, b);
    // The stack does see them.
    assert_ne!(
        render(&plain, Mode::Stack, (40, 40), 4, None).sums,
        render(&hidden, Mode::Stack, (40, 40), 4, None).sums
    );
}

/// Nor in the modes without state: their shadow rays pass through what is not there.
#[test]
fn hidden_surfaces_cast_no_shadows() {
    let [plain, hidden, seen] = [room(), with_balls(-1), with_balls(3)].map(ready);
    for mode in [Mode::Rectified, Mode::Reference] {
        let [plain, hidden, seen] = [&plain, &hidden, &seen].map(|s| render(s, mode, (40, 40), 4, None));
        assert!(mean(&plain).0 > 0.05);
        assert_eq!(hidden.events.total(), 0);
        assert_eq!(plain.sums, hidden.sums, "{mode}");
        assert_ne!(plain.sums, seen.sums);
    }
}

#[test]
fn a_trace_shows_what_was_skipped() {
    let scene = ready(with_balls(-1));
    let ray = Ray::new(DVec3::new(0.3, 9.0, 0.1), DVec3::NEG_Y);
    let path = trace(&scene, Mode::Priority, ray, Follow::Transmit, 0, None);
    let skipped: Vec<_> = path.vertices.iter().filter(|v| v.event == VertexEvent::Skip).collect();
    assert!(skipped.len() > 16, "{}", skipped.len());
    for vertex in skipped {
        assert!(vertex.refractor.is_some() && vertex.is_consistent);
        assert_eq!((&vertex.from, &vertex.to, vertex.ior_from, vertex.ior_to), (&None, &None, None, None));
    }
    let others: Vec<_> = path.vertices.iter().filter(|v| v.event != VertexEvent::Skip).map(|v| v.event).collect();
    assert_eq!(others, [VertexEvent::Transmit, VertexEvent::Scatter]);
    assert_eq!(path.events.total(), 0);
}

/// Overlapping balls with distinct priorities have one truth, which the list finds from outside and the plain stack does not. From
/// inside the list is as wrong as the stack, and says so.
#[test]
fn priority_agrees_with_the_truth_from_outside() {
    let mut description = empty(1.1);
    for (index, (x, radius, ior, priority)) in
        [(-0.4, 0.9, 1.5, 0), (0.3, 0.8, 1.33, -4), (0.1, 0.7, 1.7, 100), (0.6, 0.5, 1.2, 20)].into_iter().enumerate()
    {
        add(&mut description, sphere(DVec3::new(x, 0.05 * x, 0.0), radius), ior, 0.0);
        description.objects.refractors_mut()[index].refractor_mut().unwrap().priority = priority;
    }
    let scene = ready(description);
    let mut stack_is_wrong = 0;
    for step in 0..40 {
        let b = -0.8 + 0.04 * f64::from(step) + 0.003;
        let seen = |mode| {
            let path = through(&scene, mode, b);
            let interfaces = path.vertices.iter().filter(|v| v.event != VertexEvent::Skip);
            (interfaces.map(|v| (v.from.clone(), v.to.clone(), v.event)).collect::<Vec<_>>(), path.final_direction)
        };
        assert_eq!(seen(Mode::Priority), seen(Mode::Reference), "at {b}");
        assert_eq!(through(&scene, Mode::Priority, b).events.total(), 0);
        stack_is_wrong += u32::from(seen(Mode::Stack) != seen(Mode::Reference));
    }
    assert!(stack_is_wrong > 30, "{stack_is_wrong}");

    let inside = Ray::new(DVec3::new(0.1, 0.02, 0.01), DVec3::new(1.0, 0.2, 0.1).normalize());
    let [wrong, right] =
        [Mode::Priority, Mode::Reference].map(|mode| trace(&scene, mode, inside, Follow::Transmit, 0, None));
    assert!(wrong.events.stack_underflow > 0 && wrong.final_direction != right.final_direction);
}
