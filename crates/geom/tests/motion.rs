//! Motions and rays: what their constructors promise and refuse.

use glam::{DMat3, DVec3};
use punctual_geom::random::Random;
use punctual_geom::{Motion, MotionError, Pose, Ray, RayError};

fn pose(random: &mut Random) -> Pose {
    let [x, y, z, w] = core::array::from_fn(|_| random.fraction() - 0.5);
    let t = DVec3::from_array(core::array::from_fn(|_| random.fraction() * 4.0));
    Pose::from_quat([x, y, z, w], t).unwrap()
}

fn difference(a: &Pose, b: &Pose) -> f64 {
    let both = a.to_row_major().into_iter().zip(b.to_row_major());
    both.fold(0.0, |max: f64, (x, y)| max.max((x - y).abs()))
}

#[test]
fn a_screw_begins_and_ends_in_its_poses() {
    let mut random = Random::new(5);
    for _ in 0..1_000 {
        let (start, end) = (pose(&mut random), pose(&mut random));
        let motion = Motion::screw(start, end).unwrap();
        assert_eq!(motion.pose(0.0), start);
        assert!(difference(&motion.pose(1.0), &end) < 1e-12, "{start:?}");
    }
}

#[test]
fn the_rest_of_a_motion_has_its_poses() {
    let mut random = Random::new(7);
    for _ in 0..1_000 {
        let motion = Motion::screw(pose(&mut random), pose(&mut random)).unwrap();
        let (from, share) = (random.fraction(), random.fraction());
        let rest = motion.rest(from).unwrap();
        let whole = motion.pose(from + share * (1.0 - from));
        assert!(difference(&rest.pose(share), &whole) < 1e-11, "{motion:?}");
    }
    let motion = Motion::straight(Pose::IDENTITY, [1.0, 0.0, 0.0]).unwrap();
    assert_eq!(motion.rest(f64::NAN), Ok(motion));
    assert_eq!(motion.rest(2.0).unwrap().velocity(), DVec3::ZERO);
}

#[test]
fn small_turns_lose_no_digits() {
    let mut random = Random::new(6);
    for exponent in 3..16 {
        let start = pose(&mut random);
        let turn = DMat3::from_axis_angle(DVec3::Y, libm::pow(0.1, f64::from(exponent)));
        let end = Pose::new(
            turn * *start.rotation(),
            start.translation() + DVec3::new(1.0, 2.0, -3.0),
        )
        .unwrap();
        let motion = Motion::screw(start, end).unwrap();
        assert!(difference(&motion.pose(1.0), &end) < 1e-14, "{exponent}");
    }
}

#[test]
fn a_point_of_the_axis_stays_on_it() {
    let mut random = Random::new(7);
    let (start, point) = (pose(&mut random), DVec3::new(3.0, -1.0, 2.0));
    let velocity = DVec3::new(0.5, 0.25, -1.0);
    let motion = Motion::turning(start, velocity, [0.3, 9.0, -2.0], point).unwrap();
    let of_body = start.inverse().unwrap().transform_point(point);
    for i in 0..=100 {
        let time = f64::from(i) / 100.0;
        let at = motion.pose(time).transform_point(of_body);
        assert!((at - point - velocity * time).length() < 1e-13, "{time}");
    }
}

#[test]
fn parts_stay_where_they_are_in_their_body() {
    let mut random = Random::new(8);
    for _ in 0..100 {
        let (start, end, place) = (pose(&mut random), pose(&mut random), pose(&mut random));
        let motion = Motion::screw(start, end).unwrap();
        let part = motion.of_part(&place).unwrap();
        for time in [0.0, 0.3, 1.0] {
            let there = motion.pose(time).compose(&place).unwrap();
            assert!(difference(&part.pose(time), &there) < 1e-13, "{motion:?}");
        }
    }
}

#[test]
fn bad_motions_are_refused_by_name() {
    let start = Pose::IDENTITY;
    assert_eq!(
        Motion::straight(start, [0.0, f64::NAN, 0.0]),
        Err(MotionError::NotFinite)
    );
    assert_eq!(
        Motion::straight(start, [1e300, 0.0, 0.0]),
        Err(MotionError::TooLarge)
    );
    assert_eq!(
        Motion::turning(start, [0.0; 3], [2e6, 0.0, 0.0], [0.0; 3]),
        Err(MotionError::TooLarge)
    );
    assert_eq!(
        Motion::turning(start, [0.0; 3], [1.0; 3], [f64::INFINITY, 0.0, 0.0]),
        Err(MotionError::NotFinite)
    );
}

#[test]
fn bad_rays_are_refused_by_name() {
    assert_eq!(
        Ray::new([0.0; 3], [0.0, -0.0, 0.0]),
        Err(RayError::NoDirection)
    );
    assert_eq!(Ray::segment([1.0; 3], [1.0; 3]), Err(RayError::NoDirection));
    assert_eq!(
        Ray::new([0.0; 3], [0.0, f64::NAN, 0.0]),
        Err(RayError::NotFinite { number: 4 })
    );
    assert_eq!(
        Ray::new([0.0, 0.0, 1e302], [1.0; 3]),
        Err(RayError::TooLarge { number: 2 })
    );
    assert_eq!(
        RayError::NotFinite { number: 4 }.to_string(),
        "y of the ray's direction or end is not finite"
    );
    let ray = Ray::new([1.0; 3], [0.0, 2.0, 0.0])
        .unwrap()
        .within(f64::NAN, f64::NAN);
    assert_eq!(
        (ray.limits(), ray.at(0.5)),
        ([0.0, f64::INFINITY], DVec3::new(1.0, 2.0, 1.0))
    );
}
