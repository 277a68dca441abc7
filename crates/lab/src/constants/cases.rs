//! Which meshes are asked about, and where: case folders, pairs of files, built-in shapes.

use std::path::Path;

use punctual::glam::{DQuat, DVec3};
use punctual::internals::Random;
use punctual::{Budget, Mesh, Motion, Pose, Query, Tree, Verdict, Workspace, shapes};
use punctual_io::load;

use crate::files;
use crate::report::Failure;

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
    /// If one of the files cannot be read.
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
        Ok(Self::generated(
            &name,
            load(Path::new(a))?.mesh,
            load(Path::new(b))?.mesh,
        ))
    }

    /// Pairs of built-in shapes, approached like that.
    pub fn shapes() -> Vec<Self> {
        let sphere = || shapes::icosphere(5);
        let ring = || shapes::torus(1.0, 0.2, 96);
        let knot = || shapes::torus_knot(2, 3, 0.1, 512);
        let gear = || shapes::gear(20, 3);
        let field = || shapes::height_field(100, 3);
        let plate = || shapes::cuboid(punctual::glam::Vec3::new(1.0, 0.5, 0.05), 30);
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

    fn generated(name: &str, a: Mesh, b: Mesh) -> Self {
        let (a, b) = (Tree::new(a), Tree::new(b));
        let poses = Approaches::new(&a, &b).poses();
        let motions = between(&poses, false);
        Self {
            name: format!("approach_{name}"),
            a,
            b,
            poses,
            motions,
            is_motion: false,
        }
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

/// Directions from which B comes.
const APPROACHES: usize = 12;

/// How far past first touch, in percent of the smaller diagonal; negative is deeper.
const OFFSETS: [f64; 10] = [-15.0, -5.0, -2.0, -0.5, -0.1, -0.01, 0.01, 0.1, 0.5, 2.0];

/// Places of B where it touches A first, as it comes along random lines.
struct Approaches<'t> {
    a: &'t Tree,
    b: &'t Tree,
    /// The smaller diagonal of the two boxes, and the mean of both.
    size: f64,
    reach: f64,
    random: Random,
    workspace: Workspace,
}

/// First touch: B turned, on a line through a point, so far along.
struct Touch {
    turn: DQuat,
    start: DVec3,
    direction: DVec3,
    along: f64,
}

impl Touch {
    fn pose(&self, approaches: &Approaches, along: f64) -> Option<Pose> {
        let center = self.turn * approaches.b.mesh().aabb().center();
        Pose::from_quat(self.turn, self.start + self.direction * along - center).ok()
    }
}

impl<'t> Approaches<'t> {
    fn new(a: &'t Tree, b: &'t Tree) -> Self {
        let diagonals = [a, b].map(|tree| tree.mesh().aabb().extents().length());
        let (size, reach) = (
            diagonals[0].min(diagonals[1]),
            0.5 * (diagonals[0] + diagonals[1]),
        );
        Self {
            a,
            b,
            size,
            reach,
            random: Random::new(1),
            workspace: Workspace::new(),
        }
    }

    /// A little before and behind the touch, from all sides.
    fn poses(&mut self) -> Vec<Pose> {
        let touches: Vec<_> = (0..APPROACHES).filter_map(|_| self.touch()).collect();
        let at =
            |touch: &Touch, offset: &f64| touch.pose(self, touch.along + 0.01 * offset * self.size);
        touches
            .iter()
            .flat_map(|touch| OFFSETS.iter().filter_map(move |offset| at(touch, offset)))
            .collect()
    }

    /// The first touch on a random line; a line that passes by is drawn again, but not for ever.
    fn touch(&mut self) -> Option<Touch> {
        (0..20).find_map(|_| self.touch_on_line())
    }

    fn touch_on_line(&mut self) -> Option<Touch> {
        let random = &mut self.random;
        let turn = DQuat::from_xyzw(
            normal(random),
            normal(random),
            normal(random),
            normal(random),
        )
        .normalize();
        let direction = random_direction(random);
        let start = self.a.mesh().aabb().center()
            + (random_direction(random) * 0.3 * self.reach).reject_from(direction);
        let mut touch = Touch {
            turn,
            start,
            direction,
            along: 0.0,
        };
        let step = 0.005 * self.size.max(0.1 * self.reach);
        let steps = (2.0 * self.reach / step) as usize;
        let far = self.reach;
        let mut inside = (0..steps)
            .map(|i| far - step * i as f64)
            .find(|&along| self.meets(&touch, along))?;
        let mut outside = inside + step;
        for _ in 0..40 {
            let middle = 0.5 * (outside + inside);
            if self.meets(&touch, middle) {
                inside = middle
            } else {
                outside = middle
            }
        }
        touch.along = outside;
        Some(touch)
    }

    fn meets(&mut self, touch: &Touch, along: f64) -> bool {
        touch.pose(self, along).is_some_and(|pose| {
            let outcome = Query::intersection(self.a, self.b, pose)
                .run(&mut self.workspace, Budget::unlimited());
            matches!(outcome.value, Verdict::Intersecting { .. })
        })
    }
}

/// About normal: the sum of twelve, less its mean.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.fraction()).sum::<f64>() - 6.0
}

fn random_direction(random: &mut Random) -> DVec3 {
    DVec3::new(normal(random), normal(random), normal(random)).normalize_or(DVec3::X)
}
