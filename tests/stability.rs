//! The stability report: every case that can be run passes, with the shipping code and not with another, and what was not run or not met
//! is never a pass.

use std::sync::atomic::AtomicBool;

use iorect::report::stability::{Case, Effort, Subject, cases, maps, sweeps};

#[expect(clippy::print_stdout, reason = "shown on failure, and asked for with --nocapture")]
fn show(case: &Case) {
    println!(
        "{:>4} {:<70} {:<8} {:>3} in {:.2} s {}",
        case.number.map_or("+".to_owned(), |n| n.to_string()),
        case.name,
        case.outcome.name(),
        case.measurements.len(),
        case.seconds,
        case.outcome.reason()
    );
    if let Some(worst) = case.worst() {
        println!("       worst: {worst:?}");
    }
}

#[test]
fn all_forty() {
    let never = AtomicBool::new(false);
    let subject = Subject::shipped(Effort::Quick, &never);
    for definition in cases() {
        let case = definition.run(&subject);
        show(&case);
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "shown on failure, and asked for with --nocapture")]
fn all_sweeps() {
    let never = AtomicBool::new(false);
    let subject = Subject::shipped(Effort::Quick, &never);
    for definition in sweeps() {
        let sweep = definition.run(&subject);
        println!("{} {:?} in {:.2}", sweep.name, sweep.outcome, sweep.seconds);
        for step in &sweep.steps {
            let m = &step.measurement;
            println!(
                "     {:e} {:?} {} {} {} err {:e} bound {:e} {}",
                step.x,
                step.label,
                m.what,
                m.measured,
                m.expected,
                m.error,
                m.bound,
                m.is_within_bound()
            );
        }
    }
    for m in maps(&subject).unwrap() {
        println!(
            "{} {} {} {}x{} wrong {} worst {:e} well {:e}",
            m.formula,
            m.quantity,
            m.row_parameter,
            m.rows.len(),
            m.etas.len(),
            m.wrong_decisions,
            m.worst,
            m.worst_well_conditioned
        );
    }
}
