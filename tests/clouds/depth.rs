//! Points of depth images.

use punctual::{DepthCamera, DepthError};

const CAMERA: DepthCamera = DepthCamera {
    size: [4, 3],
    focal: [500.0, -400.0],
    center: [1.5, 1.0],
    scale: 1.0,
};

#[test]
fn pixels_lie_on_their_rays_and_those_without_depth_are_passed_over() {
    let none = [
        0.0,
        -0.0,
        -1.0,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
    ];
    let depths: Vec<_> = none
        .into_iter()
        .chain([1.0, 2.0, 0.5, 1e-40, 3.0])
        .collect();
    let mut points = vec![[9.0; 3]; 100];
    let room = points.capacity();
    let scaled = DepthCamera {
        scale: 2.0,
        ..CAMERA
    };
    scaled.points(&depths, &mut points).unwrap();
    assert_eq!((points.len(), points.capacity()), (5, room));
    for (point, pixel) in points.iter().zip(7..) {
        let (i, j) = (f64::from(pixel % 4), f64::from(pixel / 4));
        let z = 2.0 * f64::from(depths[pixel as usize]);
        let truth = [z * (i - 1.5) / 500.0, z * (j - 1.0) / -400.0, z];
        for (x, truth) in point.iter().zip(truth) {
            assert!((f64::from(*x) - truth).abs() <= 1e-7 * truth.abs() + 1e-45);
        }
    }
    let empty = DepthCamera {
        size: [0, 7],
        ..CAMERA
    };
    empty.points(&[], &mut points).unwrap();
    assert!(points.is_empty());
}

#[test]
fn wrong_cameras_are_refused_by_name() {
    let mut points = vec![[1.0; 3]];
    let refused = |camera: DepthCamera, depths: &[f32], points: &mut _| {
        let error = camera.points(depths, points).unwrap_err();
        (error, error.to_string())
    };
    let all = &[1.0; 12];
    let (error, text) = refused(CAMERA, &[1.0; 11], &mut points);
    assert_eq!(
        error,
        DepthError::Count {
            given: 11,
            size: [4, 3]
        }
    );
    assert_eq!(text, "11 depths for an image of 4 x 3 pixels");
    let huge = DepthCamera {
        size: [usize::MAX; 2],
        ..CAMERA
    };
    assert!(matches!(
        refused(huge, all, &mut points).0,
        DepthError::Count { .. }
    ));
    for wrong in [0.0, f64::NAN, f64::INFINITY] {
        let focal = DepthCamera {
            focal: [500.0, wrong],
            ..CAMERA
        };
        assert_eq!(
            refused(focal, all, &mut points).1,
            "focal[1] is 0 or not finite"
        );
        let scale = DepthCamera {
            scale: wrong,
            ..CAMERA
        };
        assert_eq!(
            refused(scale, all, &mut points).1,
            "scale is not positive and finite"
        );
    }
    let center = DepthCamera {
        center: [f64::NAN, 0.0],
        ..CAMERA
    };
    assert_eq!(
        refused(center, all, &mut points).1,
        "center[0] is not finite"
    );
    assert_eq!(points, [[1.0; 3]]);
}
