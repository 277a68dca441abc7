//! Points of depth images.

use alloc::vec::Vec;
use core::fmt;

/// A pinhole camera, whose depth images become points. Rows go from top to bottom, and so does `y`;
/// `x` goes to the right and `z` forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthCamera {
    /// Number of pixels of a row, and number of rows.
    pub size: [usize; 2],
    /// Focal lengths `fx`, `fy` in pixels; negative ones mirror.
    pub focal: [f64; 2],
    /// The principal point `cx`, `cy` in pixels: where the axis of the camera passes. The centre of
    /// the first pixel is at 0, 0.
    pub center: [f64; 2],
    /// The length of one unit of depth: 1 if depths are in the unit of the points, 0.001 for
    /// millimetres and points in metres.
    pub scale: f64,
}

impl DepthCamera {
    /// Writes the points of a depth image, row by row, over those that `points` holds. Each pixel
    /// `(i, j)` with the depth `d` is the point `(d (i - cx) / fx, d (j - cy) / fy, d)`, times the
    /// scale, in the frame of the camera. Pixels without a depth, 0, negative, infinite or NaN, are
    /// passed over, and so are points beyond the range of `f32`. `O(pixels)`; allocates only if
    /// `points` has not the room.
    ///
    /// ```
    /// use punctual::{DepthCamera, Tree};
    /// let camera = DepthCamera {
    ///     size: [3, 2],
    ///     focal: [2.0; 2],
    ///     center: [1.0, 0.5],
    ///     scale: 0.001,
    /// };
    /// let (depths, mut points) = ([1000.0, 0.0, 2000.0, f32::NAN, 500.0, -1.0], Vec::new());
    /// camera.points(&depths, &mut points)?;
    /// assert_eq!(points, [[-0.5, -0.25, 1.0], [1.0, -0.5, 2.0], [0.0, 0.125, 0.5]]);
    /// let cloud = Tree::from_points(points.iter().copied())?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a number of the camera is not finite, a focal length is 0 or the scale is not positive,
    /// or if there are more or fewer depths than pixels. Then `points` stays as it was.
    pub fn points(&self, depths: &[f32], points: &mut Vec<[f32; 3]>) -> Result<(), DepthError> {
        let numbers = [
            ("focal[0]", self.focal[0], self.focal[0] != 0.0),
            ("focal[1]", self.focal[1], self.focal[1] != 0.0),
            ("center[0]", self.center[0], true),
            ("center[1]", self.center[1], true),
            ("scale", self.scale, self.scale > 0.0),
        ];
        let wrong = numbers
            .iter()
            .find(|(_, x, fits)| !(x.is_finite() && *fits));
        if let Some(&(name, ..)) = wrong {
            return Err(DepthError::Number(name));
        }
        let [width, height] = self.size;
        if width.checked_mul(height) != Some(depths.len()) {
            let given = depths.len();
            return Err(DepthError::Count {
                given,
                size: self.size,
            });
        }
        points.clear();
        points.reserve(depths.len());
        for (j, row) in depths.chunks_exact(width.max(1)).enumerate() {
            let y = (j as f64 - self.center[1]) / self.focal[1];
            for (i, depth) in row.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
                let z = f64::from(*depth) * self.scale;
                let x = (i as f64 - self.center[0]) / self.focal[0];
                let point = [x * z, y * z, z].map(|x| x as f32);
                if point.iter().all(|x| x.is_finite()) {
                    points.push(point);
                }
            }
        }
        Ok(())
    }
}

/// Reasons why a depth image is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DepthError {
    /// This number of the camera is infinite, NaN, or 0 where it must not be.
    Number(&'static str),
    /// There are more or fewer depths than pixels.
    Count {
        /// Number of depths.
        given: usize,
        /// Number of pixels of a row, and of rows.
        size: [usize; 2],
    },
}

impl fmt::Display for DepthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number("scale") => f.write_str("scale is not positive and finite"),
            Self::Number(name) if name.starts_with("focal") => {
                write!(f, "{name} is 0 or not finite")
            }
            Self::Number(name) => write!(f, "{name} is not finite"),
            Self::Count {
                given,
                size: [x, y],
            } => {
                write!(f, "{given} depths for an image of {x} x {y} pixels")
            }
        }
    }
}

impl core::error::Error for DepthError {}
