//! Which meshes are asked about, and where: case folders, pairs of files, built-in shapes.

use std::path::Path;

use punctual::glam::Vec3;
use punctual::{Mesh, Motion, Pose, Tree, shapes};
use punctual_io::load;

use crate::approach::{self, Approach};
use crate::files;
use crate::report::Failure;

/// Poses of B around its first touch with A, on twelve lines.
const POSES: usize = 12 * OFFSETS.len();

/// How far before the first touch, in percent of the smaller diagonal; negative is deeper.
const OFFSETS: [f64; 10] = [-15.0, -5.0, -2.0, -0.5, -0.1, -0.01, 0.01, 0.1, 0.5, 2.0];

/// A pair of meshes and the poses to ask about.
pub struct Case {
    pub(super) name: String,
    pub(super) a: Tree,
    pub(super) b: Tree,
    pub(super) poses: Vec<Pose>,
    /// Listed ones, or those from pose to pose.
    pub(super) motions: Vec<Motion>,
    /// Whether the poses are frames of one motion.
    pub(super) is_motion: bool,
}

impl Case {
    /// A folder with `a.*`, `b.*` and `poses.txt`, or with motions, `sweeps.txt`; lines that hold none are left out.
    ///
    /// # Errors
    /// If one of the files cannot be read.
    pub fn folder(folder: &Path) -> Result<Self, Failure> {
        Self::of(folder, false)
    }

    fn of(folder: &Path, is_motion: bool) -> Result<Self, Failure> {
        let name = folder
            .file_name()
            .unwrap_or(folder.as_os_str())
            .to_string_lossy()
            .into_owned();
        let sweeps = folder.join("sweeps.txt");
        let (poses, motions) = if sweeps.exists() {
            let listed = files::motions(&sweeps)?;
            (
                Vec::new(),
                listed
                    .into_iter()
                    .filter_map(|listed| listed.entry.ok())
                    .collect(),
            )
        } else {
            let listed = files::poses(&folder.join("poses.txt"))?;
            let poses: Vec<Pose> = listed
                .into_iter()
                .filter_map(|listed| listed.entry.ok())
                .collect();
            let motions = between(&poses, is_motion);
            (poses, motions)
        };
        let [a, b] = [files::mesh(folder, "a")?, files::mesh(folder, "b")?].map(Tree::new);
        Ok(Self {
            name,
            a,
            b,
            poses,
            motions,
            is_motion,
        })
    }

    /// The same, where the poses are consecutive frames of a motion.
    ///
    /// # Errors
    /// If one of the files cannot be read.
    pub fn motion(folder: &Path) -> Result<Self, Failure> {
        Self::of(folder, true)
    }

    /// Two mesh files `A,B`: B approaches A from twelve sides and is put before and behind the first touch.
    ///
    /// # Errors
    /// If one of the files cannot be read, or B touches A on no line.
    pub fn approached(files: &str) -> Result<Self, Failure> {
        let (a, b) = files
            .split_once(',')
            .ok_or_else(|| format!("`{files}`: must be two files, A,B"))?;
        let stem = |file: &str| {
            Path::new(file)
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned()
        };
        let name = format!("{}_{}", stem(a), stem(b));
        Self::generated(&name, load(Path::new(a))?.mesh, load(Path::new(b))?.mesh)
    }

    /// Pairs of built-in shapes, approached like that.
    ///
    /// # Errors
    /// If B touches A on no line.
    pub fn shapes() -> Result<Vec<Self>, Failure> {
        let sphere = || shapes::icosphere(5);
        let ring = || shapes::torus(1.0, 0.2, 96);
        let knot = || shapes::torus_knot(2, 3, 0.1, 512);
        let gear = || shapes::gear(20, 3);
        let field = || shapes::height_field(100, 3);
        let plate = || shapes::cuboid(Vec3::new(1.0, 0.5, 0.05), 30);
        let pairs: [(&str, Mesh, Mesh); 6] = [
            ("sphere_ring", sphere(), ring()),
            ("knot_knot", knot(), knot()),
            ("gear_ring", gear(), ring()),
            ("gear_gear", gear(), gear()),
            ("field_knot", field(), knot()),
            ("plate_plate", plate(), plate()),
        ];
        pairs
            .into_iter()
            .map(|(name, a, b)| Self::generated(name, a, b))
            .collect()
    }

    fn generated(name: &str, a: Mesh, b: Mesh) -> Result<Self, Failure> {
        let (a, b) = (Tree::new(a), Tree::new(b));
        let mut approach = Approach::new(&a, &b, 1);
        let poses = approach::contact(&mut approach, POSES, false, &OFFSETS)?;
        let motions = between(&poses, false);
        Ok(Self {
            name: format!("approach_{name}"),
            a,
            b,
            poses,
            motions,
            is_motion: false,
        })
    }
}

/// The motions from pose to pose: screws from frame to frame, otherwise every second one without turn.
fn between(poses: &[Pose], are_frames: bool) -> Vec<Motion> {
    let motion = |(i, ends): (usize, &[Pose])| {
        if are_frames || i % 2 == 0 {
            Motion::screw(ends[0], ends[1])
        } else {
            let way = ends[1].translation() - ends[0].translation();
            Motion::straight(ends[0], way)
        }
    };
    let motions = poses.windows(2).enumerate().map(motion);
    motions.filter_map(Result::ok).collect()
}
