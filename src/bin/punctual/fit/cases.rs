//! Which meshes are asked about, and where: case folders, pairs of files, built-in shapes.

use std::path::{Path, PathBuf};

use punctual::glam::{DQuat, DVec3};
use punctual::{Budget, Mesh, Pose, Query, Tree, Verdict, Workspace, shapes};

use crate::load::load;
use crate::poses;
use crate::report::Failure;

/// A pair of meshes and the poses to ask about.
pub struct Case {
    pub name: String,
    pub a: Tree,
    pub b: Tree,
    pub poses: Vec<Pose>,
    /// Whether the poses are frames of one motion.
    pub is_motion: bool,
}

impl Case {
    /// A folder with `a.*`, `b.*` and `poses.txt`.
    pub fn folder(folder: &Path, is_motion: bool) -> Result<Self, Failure> {
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
        let [a, b] = [mesh_file(folder, "a")?, mesh_file(folder, "b")?];
        let listed = poses::load(&folder.join("poses.txt"))?;
        let poses = listed.into_iter().filter_map(|listed| listed.pose.ok()).collect();
        Ok(Self { name, a: Tree::new(load(&a)?), b: Tree::new(load(&b)?), poses, is_motion })
    }

    /// Two files `A,B`, approached from many sides.
    pub fn approached(files: &str) -> Result<Self, Failure> {
        let (a, b) = files.split_once(',').ok_or_else(|| format!("`{files}`: must be two files, A,B"))?;
        let stem = |file: &str| Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = format!("approach_{}_{}", stem(a), stem(b));
        Ok(Self::with_approaches(name, load(Path::new(a))?, load(Path::new(b))?))
    }

    /// Pairs of built-in shapes, approached from many sides.
    pub fn shapes() -> Vec<Self> {
        let sphere = || shapes::icosphere(5);
        let ring = || shapes::torus(1.0, 0.2, 96);
        let knot = || shapes::torus_knot(2, 3, 0.1, 512);
        let gear = || shapes::gear(20, 3);
        let field = || shapes::height_field(100, 3);
        let plate = || shapes::cuboid(punctual::glam::Vec3::new(1.0, 0.5, 0.05), 30);
        let pairs: [(&str, Mesh, Mesh); 6] = [
            ("shapes_sphere_ring", sphere(), ring()),
            ("shapes_knot_knot", knot(), knot()),
            ("shapes_gear_ring", gear(), ring()),
            ("shapes_gear_gear", gear(), gear()),
            ("shapes_field_knot", field(), knot()),
            ("shapes_plate_plate", plate(), plate()),
        ];
        pairs.into_iter().map(|(name, a, b)| Self::with_approaches(name.to_owned(), a, b)).collect()
    }

    fn with_approaches(name: String, a: Mesh, b: Mesh) -> Self {
        let (a, b) = (Tree::new(a), Tree::new(b));
        let poses = approaches(&a, &b);
        Self { name, a, b, poses, is_motion: false }
    }
}

fn mesh_file(folder: &Path, stem: &str) -> Result<PathBuf, Failure> {
    let known = ["obj", "stl", "ply", "glb"].map(|extension| folder.join(stem).with_extension(extension));
    let found = known.into_iter().find(|file| file.exists());
    found.ok_or_else(|| format!("{}: no mesh {stem}.obj, .stl, .ply or .glb", folder.display()).into())
}

/// Directions from which B comes.
const APPROACHES: usize = 12;

/// How far past first touch, in percent of the smaller diagonal; negative is deeper.
const OFFSETS: [f64; 7] = [-5.0, -2.0, -0.5, -0.1, 0.1, 0.5, 2.0];

/// B comes along random lines until it touches A first, and is put a little before and behind.
fn approaches(a: &Tree, b: &Tree) -> Vec<Pose> {
    let (box_a, box_b) = (a.mesh().aabb(), b.mesh().aabb());
    let diagonals = [box_a.extents().length(), box_b.extents().length()];
    let (size, reach) = (diagonals[0].min(diagonals[1]), 0.5 * (diagonals[0] + diagonals[1]));
    let step = 0.005 * size.max(0.1 * reach);
    let mut random = Random(1);
    let mut workspace = Workspace::new();
    let mut poses = Vec::new();
    // A line that passes by is drawn again, but not for ever.
    for _ in 0..20 * APPROACHES {
        if poses.len() == APPROACHES * OFFSETS.len() {
            break;
        }
        let turn = DQuat::from_xyzw(random.normal(), random.normal(), random.normal(), random.normal()).normalize();
        let direction = random.direction();
        let aside = (random.direction() * 0.3 * reach).reject_from(direction);
        let at = |along: f64| Pose::from_quat(turn, box_a.center() + aside + direction * along - turn * box_b.center());
        let mut meets = |along: f64| {
            at(along).is_ok_and(|pose| {
                let outcome = Query::new(a, b, pose).run(&mut workspace, Budget::unlimited());
                matches!(outcome.verdict, Verdict::Intersecting { .. })
            })
        };
        let steps = (2.0 * reach / step) as usize;
        let Some(inside) = (0..steps).map(|i| reach - step * i as f64).find(|&along| meets(along)) else { continue };
        let (mut outside, mut inside) = (inside + step, inside);
        for _ in 0..40 {
            let middle = 0.5 * (outside + inside);
            if meets(middle) { inside = middle } else { outside = middle }
        }
        poses.extend(OFFSETS.iter().filter_map(|offset| at(outside + 0.01 * offset * size).ok()));
    }
    poses
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn fraction(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// About normal: the sum of twelve, less its mean.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.fraction()).sum::<f64>() - 6.0
    }

    fn direction(&mut self) -> DVec3 {
        DVec3::new(self.normal(), self.normal(), self.normal()).normalize_or(DVec3::X)
    }
}
