//! The stability report: every case that can be run passes, with the shipping code and not with another, and what was not run or not met
//! is never a pass.

use std::sync::atomic::AtomicBool;

use iorect::render::Estimator;
use iorect::report::stability::{
    Case, Effort, ErrorKind, Formula, Measurement, NOISE_ALLOWANCE, Outcome, Stability, Subject, Sweep, cases, maps,
    sweeps,
};
use iorect::tracking::Mode;

static NEVER: AtomicBool = AtomicBool::new(false);

fn shipped() -> Subject<'static> {
    Subject::shipped(Effort::Quick, &NEVER)
}

/// A line for each case, on failure or with `--nocapture`.
#[expect(clippy::print_stdout, reason = "shown on failure, and asked for with --nocapture")]
fn show(case: &Case) {
    let number = case.number.map_or("+".to_owned(), |n| n.to_string());
    println!(
        "{number:>3} {:<72} {:<7} {:.2} s {}",
        case.name,
        case.outcome.name(),
        case.seconds,
        case.outcome.reason()
    );
}

/// Runs the cases of these numbers.
fn run_numbers(subject: &Subject, numbers: &[u32]) -> Vec<Case> {
    let chosen = cases().into_iter().filter(|case| case.number.is_some_and(|n| numbers.contains(&n)));
    let ran: Vec<Case> = chosen.map(|definition| definition.run(subject)).collect();
    ran.iter().for_each(show);
    assert_eq!(ran.len(), numbers.len());
    ran
}

#[test]
fn all_forty_cases_are_there_and_pass() {
    let ran: Vec<Case> = cases().iter().map(|definition| definition.run(&shipped())).collect();
    ran.iter().for_each(show);
    let numbers: Vec<u32> = ran.iter().filter_map(|case| case.number).collect();
    assert_eq!(numbers, (1..=40).collect::<Vec<_>>());
    assert!(ran.len() > 40, "some go beyond the forty");
    for case in &ran {
        assert!(case.outcome.is_passed() && !case.measurements.is_empty(), "{case:#?}");
        // Each comparison can fail: against another expected value it does.
        for m in &case.measurements {
            let allowed = m.bound + NOISE_ALLOWANCE * m.noise;
            let off = match m.expected {
                0.0 => 1.0f64.max(2.0 * m.bound + 8.0 * m.noise + m.measured),
                expected => expected * (1.0 + 3.0 * allowed / expected.abs().min(1.0) + 1e-6),
            };
            let against = if m.kind == ErrorKind::Absolute { Measurement::absolute } else { Measurement::relative };
            let twin = Measurement { noise: m.noise, ..against(m.what.clone(), m.measured, m.expected + off, m.bound) };
            assert!(!twin.is_within_bound(), "{}: {m:#?}", case.name);
        }
    }
    // The angles are met far better than asked for.
    let angles = ran.iter().filter(|case| matches!(case.number, Some(17..=25)));
    let worst = angles.flat_map(|case| &case.measurements).map(|m| m.error).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst}");

    let report = Stability {
        effort: Effort::Quick,
        cases: ran,
        sweeps: Vec::new(),
        maps: Vec::new(),
        by_estimators: Vec::new(),
        graphics: None,
    };
    let [passed, failed, not_run] = report.counts();
    assert_eq!([passed, failed, not_run], [report.cases.len(), 0, 0]);
    // What is written can be read back, to the last digit but one.
    let text = serde_json::to_string(&report).unwrap();
    let again: Stability = serde_json::from_str(&text).unwrap();
    assert_eq!(again.cases.len(), report.cases.len());
    for (a, b) in again.cases.iter().zip(&report.cases) {
        assert_eq!((a.number, &a.name, &a.source, &a.outcome), (b.number, &b.name, &b.source, &b.outcome));
        assert_eq!(a.measurements.len(), b.measurements.len());
        for (a, b) in a.measurements.iter().zip(&b.measurements) {
            assert_eq!((&a.what, a.kind, &a.unit, &a.limit), (&b.what, b.kind, &b.unit, &b.limit));
            assert!((a.measured - b.measured).abs() <= 1e-15 * b.measured.abs());
            assert!((a.expected - b.expected).abs() <= 1e-15 * b.expected.abs());
        }
    }
}

/// Whatever is measured in images is as right by paths from both ends.
#[test]
fn other_estimators_pass_what_is_measured_in_images() {
    for estimator in [Estimator::Bidirectional, Estimator::Merging] {
        let subject = Subject::estimator(Effort::Quick, estimator, &NEVER);
        let ran: Vec<Case> =
            cases().iter().filter(|case| case.is_of_images).map(|definition| definition.run(&subject)).collect();
        ran.iter().for_each(show);
        assert!(ran.len() >= 10);
        for case in ran {
            assert!(case.outcome.is_passed() && !case.measurements.is_empty(), "{estimator}: {case:#?}");
        }
    }
}

/// The twin: a mode that is wrong fails wherever something is nested, and passes where nothing is.
#[test]
fn a_wrong_mode_fails_the_same_cases() {
    let naive = Subject { modes: &[Mode::Naive], ..shipped() };
    for case in run_numbers(&naive, &[13, 15, 18, 19, 20, 21, 22, 25, 28, 34, 35, 36, 37, 38, 39]) {
        assert!(matches!(case.outcome, Outcome::Failed { .. }), "{case:#?}");
    }
    for case in run_numbers(&naive, &[12, 16, 17, 31]) {
        assert!(case.outcome.is_passed(), "{case:#?}");
    }
}

/// Likewise a formula that loses its digits; the form that a graphics card would evaluate keeps them where the input does.
#[test]
fn a_formula_that_loses_its_digits_fails_the_same_cases() {
    let textbook = Subject { formula: Formula::ShortTextbook, ..shipped() };
    for case in run_numbers(&textbook, &[2, 3, 4, 5, 10, 11]) {
        assert!(matches!(case.outcome, Outcome::Failed { .. }), "{case:#?}");
    }
    let short = Subject { formula: Formula::ShortShipped, ..shipped() };
    for case in run_numbers(&short, &[1, 2, 3, 4, 5, 6, 9, 10]) {
        assert!(case.outcome.is_passed(), "{case:#?}");
    }
    // R + T is off by up to ten roundings, which for 1000 : 1 is a little more than what is asked of f64.
    let closure = run_numbers(&short, &[11]).remove(0);
    assert!(closure.measurements.iter().all(|m| m.error < 6e-7), "{closure:#?}");
    let critical = sweeps().into_iter().find(|sweep| sweep.name == "Critical angles").unwrap();
    assert!(!critical.run(&textbook).outcome.is_passed());
}

#[expect(clippy::print_stdout, reason = "shown on failure, and asked for with --nocapture")]
fn show_sweep(sweep: &Sweep) {
    println!("{:<25} {:?} {:.2} s", sweep.name, sweep.outcome, sweep.seconds);
    for step in sweep.steps.iter().filter(|step| !step.measurement.is_within_bound()) {
        println!("  {:e} {:?}", step.x, step.measurement);
    }
}

/// Sweeps go on to where something gives way: there the reason is known, and everything else is met.
#[test]
fn sweeps_are_met_or_say_why_not() {
    let ran: Vec<Sweep> = sweeps().iter().map(|definition| definition.run(&shipped())).collect();
    ran.iter().for_each(show_sweep);
    for sweep in &ran {
        assert!(!sweep.steps.is_empty(), "{}", sweep.name);
        for step in sweep.steps.iter().filter(|step| !step.measurement.is_within_bound()) {
            assert!(step.measurement.limit.is_some(), "{}: {step:#?}", sweep.name);
        }
        let gives_way = ["Gap", "Offset", "Slivers"].contains(&sweep.name.as_str());
        assert!(sweep.outcome.is_passed() || gives_way, "{}: {}", sweep.name, sweep.outcome.reason());
    }
    let of = |name: &str| ran.iter().find(|sweep| sweep.name == name).unwrap();
    let is_met = |step: &iorect::report::stability::Step| step.measurement.is_within_bound();
    assert!(of("Gap").steps.iter().filter(|s| s.x >= 1e-6 || s.x == 0.0).all(is_met));
    assert!(of("Offset").steps.iter().filter(|s| s.x <= 1e3).all(is_met));
    assert!(of("Slivers").steps.iter().filter(|s| s.x <= 1e5).all(is_met));
    // The twin.
    let naive = Subject { modes: &[Mode::Naive], ..shipped() };
    for definition in
        sweeps().iter().filter(|sweep| ["Scale", "Depth of nesting", "Built-in scenes"].contains(&sweep.name))
    {
        assert!(matches!(definition.run(&naive).outcome, Outcome::Failed { .. }), "{}", definition.name);
    }
}

/// With more samples noise hides less.
#[test]
#[ignore = "takes minutes: run with --ignored before publishing figures"]
fn full_effort() {
    let subject = Subject::shipped(Effort::Full, &NEVER);
    let ran: Vec<Case> = cases().iter().map(|definition| definition.run(&subject)).collect();
    ran.iter().for_each(show);
    sweeps().iter().for_each(|definition| show_sweep(&definition.run(&subject)));
    assert!(ran.iter().all(|case| case.outcome.is_passed()));
}

#[test]
fn maps_tell_formulas_apart() {
    let maps = maps(&shipped()).unwrap();
    assert_eq!(maps.len(), 2 * 2 * Formula::ALL.len());
    for map in &maps {
        let errors = || map.relative_errors.iter().flatten().flatten();
        assert_eq!(map.relative_errors.len(), map.rows.len());
        assert!(map.relative_errors.iter().all(|row| row.len() == map.etas.len()));
        assert!(map.etas.is_sorted() && map.rows.is_sorted());
        assert!(errors().all(|e| e.is_finite()) && errors().count() > 800);
        assert_eq!(errors().copied().fold(0.0, f64::max), map.worst);
        let well = map.worst_well_conditioned;
        let is_textbook = map.formula == Formula::ShortTextbook.name();
        let bound = if map.formula == Formula::Shipped.name() { 2e-15 } else { 1e-6 };
        assert_eq!(well > bound, is_textbook, "{}, {}: {well}", map.formula, map.quantity);
        assert_eq!(map.wrong_decisions > 0, is_textbook, "{}, {}", map.formula, map.quantity);
    }
}

#[test]
fn outcomes_are_honest() {
    let good = Measurement::absolute("a", 1.0, 1.1, 0.2);
    let bad = Measurement::relative("b", 1.0, 1.1, 0.01).limited_by("the reason");
    let not_a_number = Measurement::absolute("c", f64::NAN, 0.0, 1e9);
    assert!(Outcome::of([&good]).is_passed());
    for measurements in [vec![], vec![&bad], vec![&good, &bad], vec![&not_a_number]] {
        assert!(matches!(Outcome::of(measurements), Outcome::Failed { .. }));
    }
    assert!(Outcome::of([&bad]).reason().contains("the reason"));
    // Noise widens the bound by four standard errors, in the unit of the value.
    let noisy = Measurement::relative("d", 90.0, 100.0, 0.01);
    assert!(!noisy.clone().with_noise(2.0).is_within_bound() && noisy.with_noise(2.5).is_within_bound());
    // A NaN is kept and found again as one, and stays a failure.
    let mut bytes = Vec::new();
    ciborium::into_writer(&not_a_number, &mut bytes).unwrap();
    let again: Measurement = ciborium::from_reader(&bytes[..]).unwrap();
    assert!(again.measured.is_nan() && !again.is_within_bound());
}

#[test]
fn what_is_cancelled_is_not_run() {
    let cancel = AtomicBool::new(true);
    let subject = Subject::shipped(Effort::Quick, &cancel);
    for case in cases().iter().map(|definition| definition.run(&subject)) {
        assert!(matches!(case.outcome, Outcome::NotRun { .. }), "{case:?}");
    }
    assert!(maps(&subject).is_none());
}

/// What is measured in images is put to the graphics processor, which is exact where f32 is: in scenes whose expected values are means of many samples.
#[cfg(feature = "gpu")]
#[test]
fn cases_in_images_are_put_to_the_graphics_processor() {
    match iorect::render::choice::adapter() {
        Ok(_) => {}
        Err(why) => return assert!(std::env::var_os("CI").is_none(), "{why}"),
    }
    let cancel = AtomicBool::new(false);
    let of_images: Vec<_> = cases().into_iter().filter(|case| case.is_of_images).collect();
    assert!(of_images.len() > 8);
    for case in of_images.iter().filter(|case| matches!(case.number, Some(12 | 34))) {
        let found = case.run(&Subject::graphics(Effort::Quick, &cancel));
        let worst = found.measurements.iter().map(|m| m.error / m.expected.abs().max(1e-9)).fold(0.0, f64::max);
        assert!(!found.measurements.is_empty() && worst < 1e-2, "{}: {worst}, {:?}", case.name, found.outcome);
        // The twin: it is not the CPU that has rendered them.
        let by_cpu = case.run(&Subject { modes: &[Mode::Rectified], ..Subject::shipped(Effort::Quick, &cancel) });
        let measured = |case: &Case| case.measurements.iter().map(|m| m.measured).collect::<Vec<_>>();
        assert_ne!(measured(&found), measured(&by_cpu), "{}", case.name);
    }
}
