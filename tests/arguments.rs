//! Numbers that a query cannot use are named, whichever they are; what is asked in spite of them goes by the nearest
//! that it can.

use punctual::clock::ManualClock;
use punctual::distance::Distance;
use punctual::glam::{DMat3, DVec3};
use punctual::intersection::Intersection;
use punctual::{Budget, Motion, OptionError, Pose, Query, Tree, Workspace, shapes};

fn named<Q>(query: Result<Q, OptionError>) -> Option<&'static str> {
    query.err().map(|error| {
        assert!(error.to_string().starts_with(error.argument), "{error}");
        error.argument
    })
}

const BAD: [f64; 4] = [-1e-300, f64::NEG_INFINITY, f64::NAN, -f64::NAN];
const GOOD: [f64; 5] = [0.0, -0.0, f64::MIN_POSITIVE, 1.0, 1e300];

#[test]
fn numbers_out_of_range_are_named() {
    let (a, b) = (
        Tree::new(shapes::icosphere(1)),
        Tree::new(shapes::icosphere(2)),
    );
    let motion = Motion::straight(Pose::IDENTITY, [1.0, 0.0, 0.0]).unwrap();
    let distance = Query::distance(&a, &b, Pose::IDENTITY);
    let contact = Query::contacts(&a, &b, Pose::IDENTITY);
    let motion = Query::impact(&a, &b, motion);
    let all = |x: f64| {
        [
            (
                "absolute_tolerance",
                named(distance.absolute_tolerance(x).checked()),
                true,
            ),
            (
                "relative_tolerance",
                named(distance.relative_tolerance(x).checked()),
                true,
            ),
            (
                "margins[0]",
                named(distance.margins([x, 0.0]).checked()),
                true,
            ),
            (
                "margins[1]",
                named(distance.margins([0.0, x]).checked()),
                true,
            ),
            (
                "closer_than",
                named(distance.closer_than(x).checked()),
                false,
            ),
            ("margin", named(contact.margin(x).checked()), false),
            ("tolerance", named(motion.tolerance(x).checked()), true),
            (
                "time_tolerance",
                named(motion.time_tolerance(x).checked()),
                true,
            ),
            (
                "margins[0]",
                named(motion.margins([x, 0.0]).checked()),
                true,
            ),
            (
                "margins[1]",
                named(motion.margins([0.0, x]).checked()),
                true,
            ),
        ]
    };
    for x in BAD {
        for (argument, said, _) in all(x) {
            assert_eq!(said, Some(argument), "{x}");
        }
    }
    for x in GOOD {
        assert!(all(x).iter().all(|(_, said, _)| said.is_none()), "{x}");
    }
    for (argument, said, must_be_finite) in all(f64::INFINITY) {
        assert_eq!(said, must_be_finite.then_some(argument));
    }
    // The first of several, whatever comes after it.
    let both = distance
        .relative_tolerance(-1.0)
        .absolute_tolerance(f64::NAN)
        .relative_tolerance(0.1);
    assert_eq!(named(both.checked()), Some("relative_tolerance"));
}

#[test]
fn what_is_asked_in_spite_of_them_goes_by_zero() {
    let (a, b) = (
        Tree::new(shapes::icosphere(1)),
        Tree::new(shapes::icosphere(2)),
    );
    let pose = Pose::new(DMat3::IDENTITY, DVec3::new(2.5, 0.1, 0.2)).unwrap();
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let mut run =
        |query: Query<Distance>| query.run(&mut workspace, Budget::unlimited().clock(&clock));
    let query = Query::distance(&a, &b, pose);
    let exact = run(query.absolute_tolerance(0.0));
    for bad in BAD {
        assert_eq!(run(query.absolute_tolerance(bad)), exact);
        assert_eq!(
            run(query
                .absolute_tolerance(0.0)
                .relative_tolerance(bad)
                .margins([bad; 2])),
            exact
        );
        assert_eq!(run(query.closer_than(bad)).value.closer, Some(false));
    }
    for infinite in [
        query.absolute_tolerance(f64::INFINITY),
        query.relative_tolerance(f64::INFINITY),
    ] {
        let said = run(infinite);
        assert!(
            said.value.low <= exact.value.high && exact.value.low <= said.value.high,
            "{said:?}"
        );
    }
}

#[test]
fn a_prior_that_is_no_number_is_the_default() {
    let (a, b) = (
        Tree::new(shapes::icosphere(4)),
        Tree::new(shapes::torus(1.0, 0.3, 64)),
    );
    let (mut workspace, clock) = (Workspace::new(), ManualClock::new());
    let query = Query::intersection(
        &a,
        &b,
        Pose::new(DMat3::IDENTITY, DVec3::new(0.3, 0.1, 0.2)).unwrap(),
    );
    let _ = query.run(&mut workspace, Budget::work(300).clock(&clock));
    let told = |query: Query<Intersection>| query.estimate(&workspace, None).unwrap().probability;
    assert!(told(query) < 1.0 && told(query.prior(f64::NAN)) == told(query));
}
