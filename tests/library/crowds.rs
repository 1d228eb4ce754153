//! Very many surfaces at one place, or in each other: the answers stay right, the table stays small, and the work can be ended.

use std::thread;

use crate::common::truth::{Truth, survey};
use crate::common::{Numbers, add, empty, nest, ready, sphere};
use glam::DVec3;
use iorect::check::check;
use iorect::rectify::progress::Stage;
use iorect::rectify::{Cancelled, InterfaceTable, Progress};
use iorect::scene::compile::compile;
use iorect::scene::description::{Description, Shape};
use iorect::tracking::Mode;

/// Boxes of about one size that all cross each other, of different media.
fn crossing_boxes(count: usize) -> Description {
    let mut description = empty(1.0);
    let mut numbers = Numbers(5);
    for k in 0..count {
        let offset = numbers.point(DVec3::splat(-0.05), DVec3::splat(0.05));
        let shape = Shape::Box { min: offset - 1.0, max: offset + 1.0 };
        add(&mut description, shape, 1.1 + 0.005 * (k * 37 % count) as f64, 0.0);
    }
    description
}

/// Faces that more others meet than are listed: every hit is asked about anew.
#[test]
fn crowded_faces_are_right() {
    let description = crossing_boxes(140);
    let truth = Truth::new(&description);
    let prepared = ready(description);
    let crowded = prepared.table.crowded();
    assert!(!crowded.is_empty());
    let problems = check(&prepared);
    let said: Vec<_> = problems.iter().filter(|problem| problem.kind == "crowded").map(|p| p.place.clone()).collect();
    let expected: Vec<_> = crowded.iter().map(|(object, _)| prepared.scene.object(*object).name.clone()).collect();
    assert_eq!(said, expected);
    let found = survey(&prepared, &truth, Mode::Rectified, &truth.rays(60, 3));
    assert!(found.checked > 100 && found.faults.is_empty(), "{found:?}");
}

/// Balls that all cross each other have more places where two surfaces meet than cells are made for: coarser ones say the same.
#[test]
fn coarser_cells_are_right() {
    let mut description = empty(1.0);
    let mut numbers = Numbers(11);
    for k in 0..60 {
        add(
            &mut description,
            sphere(numbers.point(DVec3::splat(-0.4), DVec3::splat(0.4)), 1.0),
            1.1 + 0.01 * f64::from(k),
            0.0,
        );
    }
    let truth = Truth::new(&description);
    let scene = ready(description);
    assert!(scene.table.crowded().is_empty());
    let found = survey(&scene, &truth, Mode::Rectified, &truth.rays(200, 3));
    assert!(found.checked > 400 && found.faults.is_empty(), "{found:?}");
}

/// Each shell has one container to ask about, however many there are around it: the table grows with their number, not with its square.
#[test]
fn a_deep_nest_has_a_short_table() {
    let depth = 3000;
    let shells: Vec<_> =
        (0..depth).map(|k| (1.0 - 0.9 * f64::from(k) / f64::from(depth), 1.3 + 0.01 * f64::from(k * 7 % 13))).collect();
    let prepared = ready(nest(1.0, &shells));
    let votes: usize = prepared.table.patches.iter().map(|patch| patch.votes.len()).sum();
    assert!(votes < 2 * shells.len(), "{votes}");
    for (k, patch) in prepared.table.patches.iter().enumerate() {
        let outside = patch.outside.map(|id| prepared.scene.medium(id).name.clone());
        let expected = if k == 0 { "world".to_owned() } else { format!("object {}", k - 1) };
        assert_eq!(outside, Some(expected));
    }
}

/// Ended in the middle, rectification stops and has no result.
#[test]
fn cancelled_in_the_middle() {
    let scene = compile(&crossing_boxes(90), None).unwrap();
    for stage in [Stage::Contacts, Stage::Cells] {
        let progress = Progress::new();
        let result = thread::scope(|scope| {
            let work = scope.spawn(|| InterfaceTable::new_watched(&scene, &progress));
            while !work.is_finished() {
                if progress.state().0 >= stage {
                    progress.cancel();
                }
                thread::yield_now();
            }
            work.join().unwrap()
        });
        assert_eq!(result.err(), Some(Cancelled), "{stage:?}");
    }
}
