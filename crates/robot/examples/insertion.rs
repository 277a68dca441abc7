//! An arm of seven joints puts a peg of 100 mm into a hole that is barely wider: the whole way is
//! proven free, although the gap is far below what samples could show: `insertion [GAP_IN_MM...]`.

use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

use punctual::glam::{DMat3, DVec3};
use punctual::{Budget, Mesh, Pose};
use punctual_robot::{Checker, EdgeAnswer, EdgeOptions, Model, Shape, UrdfOptions};

const RADIUS: f64 = 0.01;
const LENGTH: f64 = 0.1;
const KNOTS: usize = 64;

/// A block with a hole along z, whose sides are this far from the axis.
fn block(hole: f64) -> Result<Mesh, Box<dyn Error>> {
    let n = 128u32;
    let radii = [hole / (PI / f64::from(n)).cos(), 0.05];
    let corner = |i: u32| {
        let (s, c) = (2.0 * PI * f64::from(i / 4) / f64::from(n)).sin_cos();
        let r = radii[(i & 1) as usize];
        [r * c, r * s, if i & 2 > 0 { 0.12 } else { 0.0 }]
    };
    let side = |i: u32| {
        let at = |k: u32| 4 * ((i + k / 4) % n) + k % 4;
        // Inner, outer, lower and upper strip.
        [[0, 2, 4, 6], [1, 5, 3, 7], [0, 4, 1, 5], [2, 3, 6, 7]].map(|q| q.map(at))
    };
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [b, d, c]];
    let triangles = (0..n).flat_map(side).flat_map(halves);
    Ok(Mesh::from_f64((0..4 * n).map(corner), triangles)?)
}

/// The configuration near `q` whose last link has a pose: Newton's method on differences.
fn reach(model: &Model, q: &mut [f64], target: &Pose) -> Result<(), Box<dyn Error>> {
    let error = |q: &[f64]| -> Result<[f64; 6], Box<dyn Error>> {
        let pose = *model.link_poses(q)?.last().ok_or("no link")?;
        let way = target.translation() - pose.translation();
        let off = *pose.rotation() * target.rotation().transpose();
        let turn = DVec3::new(
            off.y_axis.z - off.z_axis.y,
            off.z_axis.x - off.x_axis.z,
            off.x_axis.y - off.y_axis.x,
        );
        let turn = -0.5 * turn;
        Ok([way.x, way.y, way.z, turn.x, turn.y, turn.z])
    };
    for _ in 0..30 {
        let now = error(q)?;
        let mut rows = Vec::new();
        for joint in 0..q.len() {
            let mut moved = q.to_vec();
            moved[joint] += 1e-6;
            let then = error(&moved)?;
            rows.push([0, 1, 2, 3, 4, 5].map(|i| (then[i] - now[i]) / 1e-6));
        }
        // Least squares with a little damping, by coordinates: J^T (J J^T + d)^-1 e.
        let mut a = [[0.0; 7]; 6];
        for i in 0..6 {
            for j in 0..6 {
                a[i][j] = rows.iter().map(|row| row[i] * row[j]).sum();
            }
            a[i][i] += 1e-9;
            a[i][6] = -now[i];
        }
        for i in 0..6 {
            let pivot = (i..6).max_by(|&x, &y| a[x][i].abs().total_cmp(&a[y][i].abs()));
            a.swap(i, pivot.unwrap_or(i));
            let row = a[i];
            for (_, other) in a.iter_mut().enumerate().filter(|(k, _)| *k != i) {
                let f = other[i] / row[i];
                other.iter_mut().zip(row).for_each(|(x, y)| *x -= f * y);
            }
        }
        for (value, row) in q.iter_mut().zip(&rows) {
            *value += (0..6).map(|i| row[i] * a[i][6] / a[i][i]).sum::<f64>();
        }
    }
    let left = error(q)?.iter().map(|x| x.abs()).fold(0.0, f64::max);
    if left < 1e-12 {
        Ok(())
    } else {
        Err(format!("the arm does not reach there: {left}").into())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/arm7.urdf");
    let model = std::sync::Arc::new(Model::from_urdf(own, &UrdfOptions::default())?);
    let last = model.link_names().last().ok_or("no link")?.to_string();
    let mut q = vec![0.3, 0.7, 0.2, 1.1, 0.1, 1.3, 0.4];
    let down = DMat3::from_cols(-DVec3::X, DVec3::Y, -DVec3::Z);
    let mut knots = Vec::new();
    for i in 0..KNOTS {
        let z = 0.375 - LENGTH * i as f64 / (KNOTS - 1) as f64;
        reach(&model, &mut q, &Pose::new(down, [0.45, 0.1, z])?)?;
        knots.extend_from_slice(&q);
    }
    let gaps: Vec<f64> = std::env::args()
        .skip(1)
        .map(|gap| gap.parse())
        .collect::<Result<_, _>>()?;
    let gaps = if gaps.is_empty() {
        vec![1.0, 0.1, 0.02]
    } else {
        gaps
    };
    for gap in gaps {
        for shift in [0.0, 2.0 * gap] {
            let mut checker = Checker::new(model.clone());
            let turned = Pose::new(DMat3::IDENTITY, [0.0, 0.0, 0.15 + LENGTH / 2.0])?;
            checker.attach(
                "peg",
                &*last,
                turned,
                Shape::cylinder(RADIUS, LENGTH)?,
                &[&last],
            )?;
            let outer = RADIUS / (PI / 128.0).cos();
            let hole = block(outer + 1e-3 * gap)?;
            let at = Pose::new(DMat3::IDENTITY, [0.45 + 1e-3 * shift, 0.1, 0.0])?;
            checker.add("block", at, Shape::mesh(hole))?;
            let start = Instant::now();
            let path = checker.path(&knots, &EdgeOptions::any(), Budget::unlimited())?;
            let ms = start.elapsed().as_secs_f64() * 1e3;
            println!(
                "gap {gap} mm, off by {shift}: {:?} in {ms:.1} ms, {} units, {:?}",
                path.value.answer, path.work, path.value.pair
            );
            assert_eq!(path.value.answer == EdgeAnswer::Free, shift == 0.0);
        }
    }
    Ok(())
}
