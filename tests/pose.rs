//! Poses: what is accepted, what is refused and why, and how every product is rounded.

use punctual::glam::{DMat3, DQuat, DVec3, Mat3, Vec3};
use punctual::{Pose, PoseError};

const COORDINATE_LIMIT: f64 = f64::from_bits((1023 + 1000) << 52);

/// The largest entry of `|RᵀR − I|`.
fn deviation(pose: &Pose) -> f64 {
    let product = pose.rotation().transpose() * *pose.rotation() - DMat3::IDENTITY;
    product
        .to_cols_array()
        .into_iter()
        .fold(0.0, |largest, entry| entry.abs().max(largest))
}

fn turned(t: DVec3) -> Pose {
    Pose::from_quat(DQuat::from_xyzw(0.1, -0.7, 0.3, 0.4), t).unwrap()
}

#[test]
fn points_map_as_given_to_the_bit() {
    let mut m = turned(DVec3::new(0.1, -1e9, 1e-9)).to_row_major();
    m[5] += 1e-7;
    let pose = Pose::from_row_major(m).unwrap();
    assert_eq!(pose.to_row_major(), m);
    let p = DVec3::new(1.0 / 3.0, -1e8 / 7.0, 1e-3 / 9.0);
    let image = pose.transform_point(p);
    for i in 0..3 {
        let row = &m[4 * i..];
        let expected = ((row[0] * p.x + row[1] * p.y) + row[2] * p.z) + row[3];
        assert_eq!(image[i].to_bits(), expected.to_bits());
    }
}

/// Those of another version of glam are other types, which share only their entries.
#[test]
fn vectors_and_matrices_of_other_crates_make_the_same_pose() {
    #[derive(Clone, Copy)]
    struct Foreign<T>(T);
    impl<T> AsRef<T> for Foreign<T> {
        fn as_ref(&self) -> &T {
            &self.0
        }
    }
    impl<T, const N: usize> From<Foreign<[T; N]>> for [T; N] {
        fn from(foreign: Foreign<[T; N]>) -> Self {
            foreign.0
        }
    }
    let pose = turned(DVec3::new(0.1, -1e9, 1e-9));
    let (rotation, translation) = (pose.rotation(), Foreign(pose.translation().to_array()));
    let [x, y, z] = rotation.to_cols_array_2d().map(Foreign);
    let quaternion = DQuat::from_xyzw(0.1, -0.7, 0.3, 0.4);
    assert_eq!(
        Pose::new(Foreign(rotation.to_cols_array()), translation).unwrap(),
        pose
    );
    assert_eq!(Pose::from_axes(x, y, z, translation).unwrap(), pose);
    assert_eq!(
        Pose::from_quat(Foreign(quaternion.to_array()), translation).unwrap(),
        pose
    );
    assert_eq!(
        pose.transform_point(x),
        pose.transform_point(rotation.x_axis)
    );

    let (rotation, translation) = pose.to_f32();
    let narrow = Pose::from_f32(
        Foreign(rotation.to_cols_array()),
        Foreign(translation.to_array()),
    );
    assert_eq!(narrow, Pose::from_f32(rotation, translation));
}

#[test]
fn multiply_and_add_round_apart() {
    // (1 + 2^-30)(1 - 2^-30) rounds to 1, so the sum is 0; fused it would be -2^-60.
    let e = 0.5f64.powi(30);
    let x = DVec3::new(1.0 + e, 0.0, 0.0);
    let pose = Pose::from_axes(x, DVec3::Y, DVec3::Z, -DVec3::X).unwrap();
    assert_eq!(pose.transform_point(DVec3::X * (1.0 - e)).x, 0.0);
}

#[test]
fn columns_are_the_images_of_the_axes() {
    let pose = Pose::from_axes(DVec3::Y, DVec3::Z, DVec3::X, DVec3::ONE).unwrap();
    assert_eq!(pose.transform_point(DVec3::X), DVec3::ONE + DVec3::Y);
    let rows = [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0];
    assert_eq!(pose.to_row_major(), rows);
}

#[test]
fn the_tolerance_has_a_sharp_edge() {
    let sheared = |s: f64| {
        let y = DVec3::new(s, 1.0, 0.0);
        Pose::from_axes(DVec3::X, y, DVec3::Z, DVec3::ZERO)
    };
    assert!(sheared(1e-3).is_ok() && sheared(-1e-3).is_ok());
    let deviation = 1e-3f64.next_up();
    assert_eq!(
        sheared(-deviation),
        Err(PoseError::NotARotation { deviation })
    );
    let scaled = |s: f64| Pose::new(DMat3::IDENTITY * s, DVec3::ZERO);
    assert!(scaled(1.000_49).is_ok() && scaled(0.999_51).is_ok());
    assert!(scaled(1.000_51).is_err() && scaled(0.999_49).is_err());
}

#[test]
fn mirrors_zeros_and_overflow_are_no_rotations() {
    let mirror = Pose::new(-DMat3::IDENTITY, DVec3::ZERO);
    assert_eq!(mirror, Err(PoseError::NotARotation { deviation: 2.0 }));
    let zero = Pose::new(DMat3::ZERO, DVec3::ZERO);
    assert_eq!(zero, Err(PoseError::NotARotation { deviation: 1.0 }));
    for entry in 0..9 {
        let mut columns = [1e300; 9];
        columns[entry] = -1e300;
        let pose = Pose::new(DMat3::from_cols_array(&columns), DVec3::ZERO);
        assert!(matches!(pose, Err(PoseError::NotARotation { .. })));
    }
}

#[test]
fn bad_numbers_are_named() {
    for entry in 0..12 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut m = Pose::IDENTITY.to_row_major();
            m[entry] = bad;
            assert_eq!(Pose::from_row_major(m), Err(PoseError::NotFinite { entry }));
        }
    }
    for axis in 0..3 {
        let mut t = DVec3::splat(-COORDINATE_LIMIT);
        assert!(Pose::new(DMat3::IDENTITY, t).is_ok());
        t[axis] = t[axis].next_down();
        let error = Pose::new(DMat3::IDENTITY, t).unwrap_err();
        assert_eq!(error, PoseError::TooFar { axis });
        let text = format!("translation along axis {axis} exceeds 2^1000");
        assert_eq!(error.to_string(), text);
    }
}

#[test]
fn quaternions_are_normalised_or_refused() {
    let q = DQuat::from_xyzw(1.0, 2.0, 3.0, 4.0);
    let pose = Pose::from_quat(q, DVec3::X).unwrap();
    assert!(deviation(&pose) < 1e-15);
    let image = pose.transform_point(DVec3::NEG_ONE) - DVec3::X;
    assert!((image - q.normalize() * DVec3::NEG_ONE).length() < 1e-15);
    for bad in [0.0, 1e-200, 1e200, f64::NAN, f64::INFINITY] {
        let q = DQuat::from_xyzw(0.0, bad, 0.0, 0.0);
        assert_eq!(Pose::from_quat(q, DVec3::X), Err(PoseError::BadQuaternion));
    }
}

#[test]
fn f32_goes_in_exactly_and_comes_out_rounded() {
    let rotation = Mat3::from_rotation_y(0.7);
    let pose = Pose::from_f32(rotation, Vec3::splat(0.1)).unwrap();
    assert_eq!(pose.to_f32(), (rotation, Vec3::splat(0.1)));
    assert_eq!(pose.translation().x, f64::from(0.1f32));
}

#[test]
fn compose_applies_the_inner_pose_first() {
    let (outer, inner) = (turned(DVec3::X), turned(DVec3::new(3.0, -2.0, 5.0)));
    let p = DVec3::new(0.3, 0.2, -0.9);
    let both = outer.compose(&inner).unwrap();
    let steps = outer.transform_point(inner.transform_point(p));
    assert!((both.transform_point(p) - steps).length() < 1e-14);
    let far = Pose::new(DMat3::IDENTITY, DVec3::splat(COORDINATE_LIMIT)).unwrap();
    assert_eq!(far.compose(&far), Err(PoseError::TooFar { axis: 0 }));
}

#[test]
fn inverse_undoes_an_inexact_rotation() {
    let y = DVec3::new(9e-4, 1.0, 0.0);
    let sheared = Pose::from_axes(DVec3::X, y, DVec3::Z, DVec3::ZERO).unwrap();
    let pose = turned(DVec3::new(1.0, 2.0, 3.0)).compose(&sheared).unwrap();
    let p = DVec3::new(-0.4, 7.0, 0.5);
    let back = pose
        .inverse()
        .unwrap()
        .transform_point(pose.transform_point(p));
    assert!((back - p).length() < 1e-14);
    assert_eq!(Pose::IDENTITY.inverse(), Ok(Pose::IDENTITY));
}

#[test]
fn an_inverse_past_the_tolerance_is_an_error() {
    let shrunk = Pose::new(DMat3::IDENTITY * 0.999_500_1, DVec3::ZERO).unwrap();
    assert!(matches!(
        shrunk.inverse(),
        Err(PoseError::NotARotation { .. })
    ));
}
