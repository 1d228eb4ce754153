//! The threads together: what reaches the board, in which order, and what stays.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::Duration;

use super::job::Job;
use super::mailbox::Taken;
use super::preparation::GRACE;
use super::preparer::REPEATS;
use super::*;
use crate::render::{EstimatorChoice, Film, RenderTask};
use crate::scene::camera::Camera;
use crate::scene::description::Shape;
use crate::tracking::prepare;
use glam::DVec3;

fn request(epoch: u64, modes: &[Mode]) -> Request {
    let description = Arc::new(crate::formats::open("nested-spheres").expect("a built-in scene"));
    Request {
        epoch,
        restarts: 0,
        camera: description.camera,
        description,
        modes: modes.to_vec(),
        surfaces: Vec::new(),
        size: [96, 64],
        settings: ImageSettings { max_depth: Some(8), ..ImageSettings::new(Mode::Rectified, 0) },
        estimator: EstimatorChoice::Path,
        backend: BackendChoice::Cpu,
        backend_choices: 0,
        sample_limit: Some(3),
        noise_target: None,
        is_paused: false,
        ground_truth: GroundTruthDemand::Off,
    }
}

/// A scene that takes a while to prepare, on any machine.
fn slow_scene(shift: f64) -> Arc<Description> {
    let mut description = crate::formats::open("nested-spheres").expect("a built-in scene");
    let ball = |x: f64| Shape::Icosphere { center: DVec3::new(x, 0.0, 0.0), radius: 1.0, subdivisions: 5 };
    for (refractor, x) in description.objects.refractors_mut().iter_mut().zip([0.0, shift]) {
        refractor.shape = ball(x);
    }
    Arc::new(description)
}

/// What `look` finds, which is asked again and again.
#[track_caller]
fn soon<T>(look: impl Fn() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "waited too long");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[track_caller]
fn until(worker: &Worker, is_met: impl Fn(&BTreeMap<Mode, Arc<Snapshot>>) -> bool) {
    soon(|| is_met(&worker.board().snapshots()).then_some(()));
}

fn quiet() -> Wake {
    Arc::new(|_| {})
}

#[test]
fn modes_advance_in_lockstep_to_the_limit() {
    let modes = [Mode::Naive, Mode::Stack, Mode::Rectified];
    let worker = Worker::start(quiet()).unwrap();
    worker.submit(request(1, &modes));
    until(&worker, |snapshots| {
        let samples: Vec<_> = snapshots.values().map(|s| (s.size, s.samples)).collect();
        assert!(samples.windows(2).all(|pair| pair[0] == pair[1]), "out of step: {samples:?}");
        snapshots.len() == 3 && snapshots.values().all(|s| s.is_done)
    });
    let snapshots = worker.board().snapshots();
    assert!(snapshots.values().all(|s| s.samples == 3 && s.size == [96, 64] && !s.is_preview()));
    // From outside a proper nest the stack knows everything: the same random numbers give the same image.
    assert_eq!(snapshots[&Mode::Stack].rgb, snapshots[&Mode::Rectified].rgb);
    assert_ne!(snapshots[&Mode::Naive].rgb, snapshots[&Mode::Rectified].rgb);
}

#[test]
fn a_higher_limit_goes_on_and_a_new_epoch_starts_anew() {
    let worker = Worker::start(quiet()).unwrap();
    let first = request(1, &[Mode::Rectified]);
    worker.submit(first.clone());
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.is_done));
    let three = Arc::clone(&worker.board().snapshots()[&Mode::Rectified]);
    worker.submit(Request { sample_limit: Some(5), ..first.clone() });
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.samples == 5));
    let five = Arc::clone(&worker.board().snapshots()[&Mode::Rectified]);
    assert!(five.seconds > three.seconds && five.epoch == 1, "the same film went on");

    // Many requests at once: the last one is what remains.
    for epoch in 2..30 {
        worker.submit(Request { epoch, restarts: epoch, ..first.clone() });
    }
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.epoch == 29 && s.is_done));
    assert_eq!(worker.board().snapshots()[&Mode::Rectified].rgb, three.rgb, "an image depends on its request alone");
}

/// Whatever is shown of `mode` from now on has at least so many samples.
#[track_caller]
fn never_below(worker: &Worker, modes: &[Mode], samples: u32, is_met: impl Fn(&BTreeMap<Mode, Arc<Snapshot>>) -> bool) {
    until(worker, |snapshots| {
        for film in snapshots.values().filter(|film| modes.contains(&film.mode)) {
            assert!(!film.is_preview() && film.samples >= samples, "{}: {} of {samples}", film.mode, film.samples);
        }
        is_met(snapshots)
    });
}

#[test]
fn films_of_other_modes_come_and_go_and_none_begins_anew() {
    let worker = Worker::start(quiet()).unwrap();
    let all = [Mode::Naive, Mode::Stack, Mode::Reference];
    let first = Request { sample_limit: Some(6), ..request(1, &all) };
    worker.submit(first.clone());
    until(&worker, |s| s.len() == 3 && s.values().all(|s| s.is_done));
    let rgb = |mode: Mode| worker.board().snapshots()[&mode].rgb.clone();
    let before = all.map(rgb);
    for modes in [&all[..1], &all[2..], &all[1..], &all[..0], &all[..2], &all[..]] {
        worker.submit(Request { modes: modes.to_vec(), ..first.clone() });
        never_below(&worker, modes, 6, |s| s.keys().eq(modes) && s.values().all(|film| film.is_done));
    }
    assert_eq!(all.map(rgb), before);
    // A mode that comes later catches up.
    worker.submit(Request { modes: vec![Mode::Stack, Mode::Rectified], ..first });
    never_below(&worker, &[Mode::Stack], 6, |s| {
        s.len() == 2 && s.values().all(|film| film.is_done && film.samples == 6)
    });
}

#[test]
fn what_was_shown_before_comes_back_with_its_samples() {
    let worker = Worker::start(quiet()).unwrap();
    let modes = [Mode::Stack, Mode::Rectified];
    let first = Request { sample_limit: Some(5), ..request(1, &modes) };
    worker.submit(first.clone());
    until(&worker, |s| s.len() == 2 && s.values().all(|s| s.is_done));
    let mut edited = Description::clone(&first.description);
    edited.world.ior = crate::optics::Ior::Constant(1.2);
    let mut moved = first.camera;
    moved.position.x += 0.1;
    let others = [
        Request { description: Arc::new(edited), ..first.clone() },
        Request { camera: moved, ..first.clone() },
        Request { size: [50, 40], ..first.clone() },
        Request { settings: ImageSettings { max_depth: Some(4), ..first.settings }, ..first.clone() },
    ];
    let mut epoch = 1;
    for other in others {
        worker.submit(Request { epoch: epoch + 1, ..other });
        until(&worker, |s| s.values().all(|film| film.epoch == epoch + 1 && film.samples >= 2));
        epoch += 2;
        worker.submit(Request { epoch, ..first.clone() });
        until(&worker, |s| {
            let now: Vec<_> = s.values().filter(|film| film.epoch == epoch).collect();
            assert!(now.iter().all(|film| !film.is_preview() && film.samples == 5), "{now:?}");
            now.len() == 2
        });
    }
    // Who wants to see it begin anew sees that.
    worker.submit(Request { epoch: epoch + 1, restarts: 1, sample_limit: Some(2), ..first });
    until(&worker, |s| s.values().all(|film| film.epoch == epoch + 1 && film.is_done && film.samples == 2));
}

#[test]
fn rendering_stops_where_there_is_little_noise() {
    let worker = Worker::start(quiet()).unwrap();
    let modes = [Mode::Stack, Mode::Rectified];
    let asked = Request { sample_limit: Some(4096), noise_target: Some(0.4), ..request(1, &modes) };
    worker.submit(asked.clone());
    until(&worker, |s| s.len() == 2 && s.values().all(|s| s.is_done));
    let films = worker.board().snapshots();
    assert!(films.values().all(|film| (16..4096).contains(&film.samples) && film.noise.unwrap() <= 0.4), "{films:?}");
    assert!(films.values().all(|film| film.samples == films[&Mode::Stack].samples));
    // Less noise: it goes on.
    worker.submit(Request { noise_target: Some(0.5 * films[&Mode::Stack].noise.unwrap()), ..asked });
    never_below(&worker, &modes, 16, |s| s.values().all(|film| film.samples > films[&Mode::Stack].samples));
}

#[test]
fn a_pause_stops_everything() {
    let worker = Worker::start(quiet()).unwrap();
    let paused = Request {
        is_paused: true,
        sample_limit: None,
        surfaces: vec![SurfaceQuantity::Class],
        ground_truth: GroundTruthDemand::On,
        ..request(1, &[Mode::Rectified])
    };
    worker.submit(paused.clone());
    let rays = || worker.board().paintings().get(&SurfaceQuantity::Class).map_or(0, |painted| painted.painting.rays);
    let is_whole =
        || worker.board().paintings().get(&SurfaceQuantity::Class).is_some_and(|painted| !painted.is_preview());
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| !s.is_preview()) && is_whole());
    let checked = || worker.board().scene().filter(|scene| scene.problems.is_some());
    let pretraced = soon(checked).prepared.table.rays();
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!((worker.board().snapshots()[&Mode::Rectified].samples, rays()), (1, 1));
    assert_eq!(worker.board().ground_truth().map_or(0, |truth| truth.samples), 0);
    assert_eq!(worker.board().scene().unwrap().prepared.table.rays(), pretraced);
    worker.submit(Request { is_paused: false, ..paused });
    until(&worker, |s| s[&Mode::Rectified].samples > 10 && rays() > 1);
    soon(|| worker.board().ground_truth().filter(|truth| truth.samples > 0));
}

#[test]
fn a_pause_stops_after_one_sample() {
    let worker = Worker::start(quiet()).unwrap();
    let paused = Request { is_paused: true, sample_limit: None, ..request(1, &[Mode::Rectified]) };
    worker.submit(paused.clone());
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| !s.is_preview()));
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(worker.board().snapshots()[&Mode::Rectified].samples, 1);
    worker.submit(Request { is_paused: false, ..paused });
    until(&worker, |s| s[&Mode::Rectified].samples > 10);
}

#[test]
fn reference_beside_others_has_a_lane_of_its_own() {
    let worker = Worker::start(quiet()).unwrap();
    worker.submit(Request { sample_limit: Some(2), ..request(1, &[Mode::Rectified, Mode::Reference]) });
    until(&worker, |s| s.len() == 2 && s.values().all(|s| s.is_done));
    worker.submit(Request { sample_limit: Some(2), ..request(2, &[Mode::Reference]) });
    until(&worker, |s| s.len() == 1 && s.values().all(|s| s.epoch == 2 && s.is_done));
}

/// Every image that is shown, the coarse ones of a drag too, is the one of its size.
#[test]
fn previews_are_images_of_their_size() {
    type Shown = Mutex<Vec<(u64, Arc<Snapshot>)>>;
    let seen: Arc<Shown> = Arc::default();
    let board: Arc<Mutex<Option<Arc<Board>>>> = Arc::default();
    let worker = {
        let (seen, board) = (Arc::clone(&seen), Arc::clone(&board));
        Worker::start(Arc::new(move |_| {
            let Some(board) = board.lock().unwrap().clone() else { return };
            let shown = board.snapshots().into_values().map(|snapshot| (snapshot.epoch, snapshot));
            seen.lock().unwrap().extend(shown);
        }))
        .unwrap()
    };
    *board.lock().unwrap() = Some(Arc::clone(worker.board()));
    let modes = [Mode::Stack, Mode::Rectified, Mode::Reference];
    let first = Request { size: [480, 320], sample_limit: Some(1), ..request(1, &modes) };
    let asked = |epoch: u64| {
        let mut asked = Request { epoch, ..first.clone() };
        asked.camera.position.x += 0.05 * epoch as f64;
        asked
    };
    for epoch in 1..6 {
        worker.submit(asked(epoch));
        std::thread::sleep(Duration::from_millis(30));
    }
    until(&worker, |s| s.len() == 3 && s.values().all(|s| s.epoch == 5 && s.is_done));
    let mut seen = seen.lock().unwrap().clone();
    seen.dedup_by(|a, b| Arc::ptr_eq(&a.1, &b.1));
    // (How many of them are previews is a matter of the machine's speed.)
    assert!(seen.len() >= 3);
    let prepared = prepare(Arc::clone(&first.description), None).unwrap();
    for (epoch, snapshot) in seen {
        let camera = Camera::new(&asked(epoch).camera).unwrap();
        let settings = ImageSettings { mode: snapshot.mode, ..first.settings };
        let mut film = Film::new(snapshot.size[0], snapshot.size[1]);
        let never = std::sync::atomic::AtomicBool::new(false);
        let task = RenderTask { prepared: &prepared, camera: &camera, settings: &settings };
        task.pass(&mut film, snapshot.samples, &never);
        assert_eq!(film.to_rgb(), snapshot.rgb, "{} at {:?}", snapshot.mode, snapshot.size);
    }
}

#[test]
fn what_can_wait_is_done_when_nothing_else_is_wanted() {
    let worker = Worker::start(quiet()).unwrap();
    let asked = request(1, &[Mode::Rectified]);
    worker.submit(asked.clone());
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.is_done));
    let rays = || worker.board().scene().map_or(0, |scene| scene.prepared.table.rays());
    // Not what the board says now: on a busy machine some of it may be done by the time the film is.
    let first = prepare(Arc::clone(&asked.description), None).unwrap().table.rays();
    assert!(first > 0);
    // Every pre-trace shoots as many rays here: nobody doubts this nest.
    until(&worker, |_| rays() == first * (1 + u64::from(REPEATS)));
    let scene = worker.board().scene().unwrap();
    assert!(scene.problems.is_some() && scene.epoch == 1);
    // An edit of optics counts on.
    let mut description = Description::clone(&asked.description);
    description.world.ior = crate::optics::Ior::Constant(1.2);
    worker.submit(Request { epoch: 2, description: Arc::new(description), ..asked });
    until(&worker, |_| rays() > first * (1 + u64::from(REPEATS)));
}

#[test]
fn surfaces_are_painted_beside_the_films_and_without_any() {
    let paintings = |worker: &Worker| worker.board().paintings();
    let worker = Worker::start(quiet()).unwrap();
    let both = vec![SurfaceQuantity::Outside, SurfaceQuantity::Class];
    let films_too = Request { surfaces: both.clone(), ..request(1, &[Mode::Rectified]) };
    worker.submit(films_too.clone());
    until(&worker, |s| s.len() == 1 && s.values().all(|s| s.is_done));
    until(&worker, |_| paintings(&worker).len() == 2 && paintings(&worker).values().all(|p| p.is_done()));
    let first = Arc::clone(&paintings(&worker)[&SurfaceQuantity::Class]);
    assert_eq!([first.painting.width, first.painting.height], [96, 64]);
    // Less of the same epoch keeps what there is; another epoch paints anew.
    worker.submit(Request { surfaces: both[1..].to_vec(), modes: Vec::new(), ..films_too.clone() });
    until(&worker, |_| paintings(&worker).len() == 1);
    assert!(Arc::ptr_eq(&paintings(&worker)[&SurfaceQuantity::Class], &first));
    worker.submit(Request { surfaces: both.clone(), modes: Vec::new(), ..films_too });
    until(&worker, |_| paintings(&worker).len() == 2 && paintings(&worker).values().all(|p| p.is_done()));
    worker.submit(Request { surfaces: both, ..request(2, &[]) });
    until(&worker, |_| {
        paintings(&worker).len() == 2 && paintings(&worker).values().all(|p| p.is_done() && p.epoch == 2)
    });
}

/// A request for less takes a painting from the board, though the painter may only see the next one, for all again.
#[test]
fn what_has_left_the_board_is_painted_anew() {
    let asked = Request { surfaces: vec![SurfaceQuantity::Class, SurfaceQuantity::Outside], ..request(1, &[]) };
    let message = || {
        Some(Box::new(Job {
            prepared: prepare(Arc::clone(&asked.description), None).unwrap(),
            camera: Camera::new(&asked.camera).unwrap(),
            modes: Vec::new(),
            request: asked.clone(),
            asked_at: Instant::now(),
        }))
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let (mailbox, board) = (Mailbox::new(), Board::default());
    let all_are_painted = || {
        let start = Instant::now();
        while !(board.paintings().len() == 2 && board.paintings().values().all(|painted| painted.is_done())) {
            if start.elapsed() > Duration::from_secs(60) {
                return false;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        true
    };
    let [at_first, again] = std::thread::scope(|scope| {
        scope.spawn(|| run_painter(&pool, &mailbox, &board, &quiet()));
        mailbox.post(message());
        let at_first = all_are_painted();
        board.lock().paintings.remove(&SurfaceQuantity::Outside);
        mailbox.post(message());
        let again = all_are_painted();
        mailbox.close();
        [at_first, again]
    });
    assert!(at_first && again, "{at_first}, {again}");
}

#[test]
fn a_ground_truth_is_kept_while_the_picture_is_the_same() {
    let worker = Worker::start(quiet()).unwrap();
    let truth_when =
        |is_met: &dyn Fn(&GroundTruth) -> bool| soon(|| worker.board().ground_truth().filter(|truth| is_met(truth)));
    let first = Request { ground_truth: GroundTruthDemand::On, ..request(1, &[Mode::Rectified]) };
    worker.submit(first.clone());
    let halves = truth_when(&|truth| truth.halves.as_ref().is_some_and(|h| h.samples >= 4)).halves.unwrap();
    assert_eq!((halves.size, halves.mean.len()), ([96, 64], 96 * 64));
    assert_ne!(halves.rgb[0], halves.rgb[1], "the halves have noise of their own");
    let film = Arc::clone(&worker.board().snapshots()[&Mode::Rectified]);
    assert!(halves.rgb.iter().all(|half| *half != film.rgb));

    // Another mode is another epoch of the same picture. Paused, it stays as it is.
    let paused =
        Request { epoch: 2, modes: vec![Mode::Stack], ground_truth: GroundTruthDemand::Paused, ..first.clone() };
    worker.submit(paused);
    let kept = truth_when(&|truth| truth.epoch == 2);
    assert!(kept.samples >= halves.samples);
    // Another view is another picture.
    let mut moved = Request { epoch: 3, ..first.clone() };
    moved.camera.position.x += 0.1;
    worker.submit(moved);
    let anew = truth_when(&|truth| truth.epoch == 3);
    assert!(anew.samples < kept.samples, "it begins anew: {} of {}", anew.samples, kept.samples);
    worker.submit(Request { epoch: 4, ..request(4, &[Mode::Rectified]) });
    until(&worker, |_| worker.board().ground_truth().is_none());
}

#[test]
fn an_impossible_request_is_told_and_the_old_scene_stays() {
    let worker = Worker::start(quiet()).unwrap();
    let good = request(1, &[Mode::Rectified]);
    worker.submit(good.clone());
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.is_done));
    let mut bad = Request { epoch: 2, ..good.clone() };
    bad.camera.target = bad.camera.position;
    worker.submit(bad);
    let (epoch, error) = soon(|| worker.board().take_failure());
    assert_eq!(epoch, 2);
    assert!(error.message.contains("direction"), "{error}");
    assert!(worker.board().scene().is_some());
    worker.submit(Request { epoch: 3, ..good });
    until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.epoch == 3 && s.is_done));
}

#[test]
fn a_long_preparation_gives_way_to_another_scene() {
    let scene = slow_scene(0.5);
    let mut preparation = Preparation::new(1);
    preparation.begun = Instant::now() - GRACE;
    let requests = Mailbox::new();
    let asked = |request: Request| Asked { request, at: Instant::now() };
    // Another view of the same scene is no reason.
    requests.post(asked(Request { description: Arc::clone(&scene), ..request(2, &[]) }));
    assert!(preparation.run(&scene, None, &requests).unwrap().is_some());
    requests.post(asked(request(3, &[])));
    assert!(preparation.run(&scene, None, &requests).unwrap().is_none());
    assert!(
        matches!(requests.wait(Some(Duration::ZERO)), Taken::Message(asked) if asked.request.epoch == 3),
        "it is still to be served"
    );
    // One that has not taken so long yet is finished.
    requests.post(asked(request(4, &[])));
    let mut preparation = Preparation::new(5);
    preparation.begun = Instant::now() + Duration::from_secs(600);
    assert!(preparation.run(&request(5, &[]).description, None, &requests).unwrap().is_some());
}

#[test]
fn a_preparation_that_is_given_up_is_told_and_the_old_scene_stays() {
    let worker = Worker::start(quiet()).unwrap();
    let is_ready = |epoch| worker.board().scene().is_some_and(|scene| scene.epoch == epoch);
    let good = request(1, &[]);
    worker.submit(good.clone());
    until(&worker, |_| is_ready(1));
    worker.submit(Request { epoch: 2, description: slow_scene(0.3), ..good.clone() });
    let (epoch, error) = soon(|| {
        if let Some(preparation) = worker.board().preparation() {
            assert_eq!(preparation.epoch, 2);
            preparation.give_up();
        }
        worker.board().take_failure()
    });
    assert!(epoch == 2 && error.message.contains("given up"), "{epoch}: {error}");
    assert!(worker.board().preparation().is_none());
    assert!(Arc::ptr_eq(&worker.board().scene().unwrap().prepared.description, &good.description));
    // What comes next is prepared.
    worker.submit(request(3, &[]));
    until(&worker, |_| is_ready(3));
}

/// Where the graphics processor computes on the CPU, pictures that have to be there at once come from the CPU itself, and only the film from it.
#[test]
fn previews_beside_a_graphics_processor_in_software_are_rendered_by_the_cpu() {
    use crate::render::{Backend, choice};
    match choice::adapter() {
        Ok(adapter) if adapter.is_software => {}
        Ok(_) => return,
        Err(why) => {
            assert!(std::env::var_os("CI").is_none() || cfg!(not(feature = "gpu")), "{why}");
            return;
        }
    }
    let mode = Mode::Rectified;
    let board = Arc::new(std::sync::OnceLock::<Arc<Board>>::new());
    let shown = Arc::new(Mutex::new(Vec::new()));
    let wake: Wake = {
        let (board, shown) = (Arc::clone(&board), Arc::clone(&shown));
        Arc::new(move |_| {
            if let Some(snapshot) = board.get().and_then(|board| board.snapshots().get(&mode).cloned()) {
                shown.lock().unwrap().push(snapshot);
            }
        })
    };
    let worker = Worker::start(wake).unwrap();
    board.set(Arc::clone(worker.board())).unwrap();
    // Without an end, so that the CPU has not finished before the shaders are compiled.
    let first = Request { backend: BackendChoice::Gpu, sample_limit: None, ..request(1, &[mode]) };
    worker.submit(first.clone());
    until(&worker, |s| s.get(&mode).is_some_and(|s| !s.is_preview() && s.backend == Backend::Gpu));
    let mut edited = Description::clone(&first.description);
    edited.media[0].ior = crate::optics::Ior::Constant(1.4);
    worker.submit(Request { epoch: 2, description: Arc::new(edited), sample_limit: Some(3), ..first });
    until(&worker, |s| s.get(&mode).is_some_and(|s| s.epoch == 2 && s.is_done));
    assert_eq!(worker.board().snapshots()[&mode].backend, Backend::Gpu);
    let shown = shown.lock().unwrap();
    let mut previews = shown.iter().filter(|snapshot| snapshot.epoch == 2 && snapshot.is_preview()).peekable();
    assert!(previews.peek().is_some(), "no preview was shown");
    assert!(previews.all(|snapshot| snapshot.backend == Backend::Cpu));
}
