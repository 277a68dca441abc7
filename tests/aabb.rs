//! Boxes parallel to the axes.

use punctual::Aabb;
use punctual::glam::DVec3;

fn unit() -> Aabb {
    Aabb::new(DVec3::ZERO, DVec3::ONE)
}

#[test]
fn touching_boxes_intersect_and_the_border_is_inside() {
    let point = Aabb::from_points([DVec3::ONE]);
    assert!(unit().intersects(&point) && point.intersects(&unit()));
    assert!(unit().contains(DVec3::ONE) && unit().contains(DVec3::ZERO));
    assert!(!point.is_empty());
}

#[test]
fn one_axis_apart_is_apart() {
    for axis in 0..3 {
        let mut far = unit();
        far.min[axis] = 1.0f64.next_up();
        far.max[axis] = 2.0;
        assert!(!unit().intersects(&far) && !far.intersects(&unit()));
        assert!(!unit().contains(far.min));
    }
}

#[test]
fn the_empty_box_is_neutral_and_meets_nothing() {
    assert_eq!(Aabb::EMPTY.union(&unit()), unit());
    assert_eq!(Aabb::from_points([DVec3::ZERO; 0]), Aabb::EMPTY);
    assert!(Aabb::EMPTY.is_empty() && !Aabb::EMPTY.intersects(&unit()));
    assert_eq!(Aabb::EMPTY.extents(), DVec3::ZERO);
    let (everything, flat) = (
        Aabb::new(DVec3::NEG_INFINITY, DVec3::INFINITY),
        Aabb::new(DVec3::X, DVec3::ONE - DVec3::X),
    );
    assert!(flat.is_empty() && everything.intersects(&unit()));
    for empty in [Aabb::EMPTY, flat] {
        assert!(!empty.intersects(&everything) && !everything.intersects(&empty));
    }
}

#[test]
fn center_and_full_extents() {
    let aabb = Aabb::from_points([DVec3::new(3.0, -1.0, 4.0), DVec3::new(1.0, 5.0, 4.0)]);
    assert_eq!(aabb.center(), DVec3::new(2.0, 2.0, 4.0));
    assert_eq!(aabb.extents(), DVec3::new(2.0, 6.0, 0.0));
}
