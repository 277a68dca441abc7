//! One question: do these two torus knots touch?
//!
//! First with all the time in the world, then with far too little, then with the rest of it.

mod common;

use std::io::Write;

use punctual::glam::{DMat3, DVec3};
use punctual::{Answer, Budget, Mode, Order, Pose, Query, StopReason, Tree, Verdict, Workspace};

fn ask(out: &mut impl Write) -> Result<(), Box<dyn std::error::Error>> {
    let a = Tree::new(punctual::shapes::torus_knot(2, 3, 0.25, 96));
    let b = Tree::new(punctual::shapes::torus_knot(3, 4, 0.2, 96));
    let (a_triangles, b_triangles) = (a.mesh().len(), b.mesh().len());
    writeln!(
        out,
        "knot A: {a_triangles} triangles, knot B: {b_triangles} triangles\n"
    )?;

    let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(0.4);
    let b_in_a = Pose::new(turn, DVec3::new(0.9, 0.6, 0.3))?;
    let mut workspace = Workspace::new();

    let touch = Query::intersection(&a, &b, b_in_a).mode(Mode::Any);
    let outcome = touch.run(&mut workspace, Budget::unlimited());
    writeln!(out, "Do they touch?           {}", in_words(&outcome))?;

    let all = touch.mode(Mode::All).order(Order::Penetration);
    let complete = all.run(&mut workspace, Budget::work(u64::MAX));
    let all_pairs = workspace.pairs().to_vec();
    writeln!(out, "Where, everywhere?       {}", in_words(&complete))?;

    writeln!(
        out,
        "\nThe same question with a budget, from nothing to everything:"
    )?;
    writeln!(
        out,
        "  budget   used  verdict       found  at most  open boxes  largest box"
    )?;
    for percent in [0, 1, 5, 20, 50, 100] {
        let budget = complete.stats.work * percent / 100;
        let outcome = all.run(&mut workspace, Budget::work(budget));
        let certificate = all.certificate(&workspace)?;
        writeln!(
            out,
            "  {percent:>5}% {:>6}  {:<12} {:>6} {:>8} {:>11} {:>12.3}",
            outcome.stats.work,
            in_a_word(&outcome),
            outcome.stats.found,
            certificate.upper_bound(),
            certificate.boxes().count(),
            certificate.largest_extent(),
        )?;
        assert!(certificate.upper_bound() >= complete.stats.found);
    }

    let mut outcome = all.run(&mut workspace, Budget::work(complete.stats.work / 3));
    let mut slices = 1;
    while outcome.stop != StopReason::Finished {
        outcome = all.resume(&mut workspace, Budget::work(complete.stats.work / 3))?;
        slices += 1;
    }
    assert_eq!(outcome, complete);
    assert_eq!(workspace.pairs(), all_pairs);
    writeln!(
        out,
        "\nIn {slices} slices instead of one: the same pairs, the same counters, to the bit."
    )?;
    Ok(())
}

fn in_a_word(outcome: &Answer<Verdict>) -> &'static str {
    outcome.value.name()
}

fn in_words(outcome: &Answer<Verdict>) -> String {
    let work = outcome.stats.work;
    match outcome.value {
        Verdict::Intersecting { witness: [a, b] }
        | Verdict::Within {
            witness: [a, b], ..
        } => {
            let found = outcome.stats.found;
            format!("yes: triangle {a} of A meets {b} of B ({found} found, {work} units of work)")
        }
        Verdict::Separated => format!("no, proved with {work} units of work"),
        Verdict::Undecided => format!("not decided within {work} units of work"),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    common::write(ask)
}
