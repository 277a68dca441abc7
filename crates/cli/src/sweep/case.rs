//! Cases: two meshes and the poses of B in A's frame.

use std::path::Path;

use punctual::glam::DVec3;
use punctual::{BuildOptions, Mesh, Pose, Tree};
use punctual_lab::files;
use punctual_lab::report::Failure;

pub struct Case {
    pub name: String,
    pub a: Tree,
    pub b: Tree,
    pub poses: Vec<Pose>,
    /// Known number of intersecting pairs of each pose, from `truth.csv` of the folder; empty without that file.
    pub known: Vec<u64>,
}

impl Case {
    pub fn new(name: &str, a: Mesh, b: Mesh, poses: Vec<Pose>) -> Self {
        // For early answers.
        let tree = |mesh| Tree::with_options(mesh, &BuildOptions::default().neighbors(true));
        Self { name: name.to_owned(), a: tree(a), b: tree(b), poses, known: Vec::new() }
    }

    /// The case of a folder with a mesh `a.*`, a mesh `b.*`, `poses.txt`, and perhaps `truth.csv` with columns `hit` and
    /// `pairs`.
    pub fn load(folder: &Path) -> Result<Self, Failure> {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().replace(',', "_");
        let list = folder.join("poses.txt");
        let poses = files::poses(&list)?
            .into_iter()
            .map(|listed| listed.pose.map_err(|what| format!("{}:{}: {what}", list.display(), listed.line).into()));
        let poses = poses.collect::<Result<Vec<Pose>, Failure>>()?;
        let mut case = Self::new(&name, files::mesh(folder, "a")?, files::mesh(folder, "b")?, poses);
        let truth = folder.join("truth.csv");
        if truth.exists() {
            case.known = known(&truth)?;
            if case.known.len() != case.poses.len() {
                return Err(format!("{}: not a line for each pose", truth.display()).into());
            }
        }
        Ok(case)
    }

    /// Length that offsets are measured by: the box diagonal of the smaller mesh.
    pub fn size(&self) -> f64 {
        size(self.a.mesh()).min(size(self.b.mesh()))
    }

    /// The boxes of the meshes along A's axes, as lower and upper corner.
    pub fn boxes(&self, pose: &Pose) -> [(DVec3, DVec3); 2] {
        let (a, b) = (self.a.mesh().aabb(), self.b.mesh().aabb());
        let center = pose.transform_point((b.min + b.max) * 0.5);
        let half = (b.max - b.min) * 0.5;
        let r = pose.rotation();
        let half = r.x_axis.abs() * half.x + r.y_axis.abs() * half.y + r.z_axis.abs() * half.z;
        [(a.min, a.max), (center - half, center + half)]
    }

    /// Whether these are apart.
    pub fn boxes_apart(&self, pose: &Pose) -> bool {
        let [(low_a, high_a), (low_b, high_b)] = self.boxes(pose);
        low_b.cmpgt(high_a).any() || high_b.cmplt(low_a).any()
    }

    /// Differs between cases with different triangles or poses (FNV-1a).
    pub fn fingerprint(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |bits: u64| {
            for byte in bits.to_le_bytes() {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
            }
        };
        for mesh in [self.a.mesh(), self.b.mesh()] {
            let coordinates = (0..mesh.len()).flat_map(|i| mesh.triangle(i)).flat_map(|v| v.to_array());
            coordinates.for_each(|x| add(x.to_bits()));
        }
        self.poses.iter().flat_map(Pose::to_row_major).for_each(|x| add(x.to_bits()));
        hash
    }
}

pub fn size(mesh: &Mesh) -> f64 {
    if mesh.is_empty() { 0.0 } else { DVec3::length(mesh.aabb().max - mesh.aabb().min) }
}

fn known(file: &Path) -> Result<Vec<u64>, Failure> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = header.iter().position(|name| *name == "pairs");
    let column = column.ok_or_else(|| format!("{}: no column pairs", file.display()))?;
    let count = |line: &str| line.split(',').nth(column)?.trim().parse().ok();
    lines
        .zip(2..)
        .map(|(line, number)| {
            count(line).ok_or_else(|| format!("{}:{number}: no number of pairs", file.display()).into())
        })
        .collect()
}
