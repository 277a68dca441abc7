//! Cases: two meshes and the poses of B in A's frame.

use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

use crate::files;
use crate::report::{self, Failure};
use punctual::{Aabb, Mesh, Pose, Tree};
use punctual_io::Loaded;

use crate::approach::{self, Approach, diagonal};

pub struct Case {
    pub name: String,
    pub a: Tree,
    pub b: Tree,
    pub poses: Vec<Pose>,
    /// Known number of intersecting pairs of each pose, from `truth.csv` of the folder; empty without that file.
    pub known: Vec<u64>,
    /// The same of distances, from `truth_distance.csv`.
    pub distances: Vec<f64>,
}

impl Case {
    pub fn new(name: &str, a: Mesh, b: Mesh, poses: Vec<Pose>) -> Self {
        Self {
            name: name.to_owned(),
            a: Tree::new(a),
            b: Tree::new(b),
            poses,
            known: Vec::new(),
            distances: Vec::new(),
        }
    }

    /// The case of a folder with a mesh `a.*`, a mesh `b.*`, `poses.txt`, and perhaps `truth.csv` with columns `hit` and
    /// `pairs`, and `truth_distance.csv` with a column `distance`.
    pub fn load(folder: &Path) -> Result<Self, Failure> {
        let name = folder
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .replace(',', "_");
        let list = folder.join("poses.txt");
        let poses = files::poses(&list)?.into_iter().map(|listed| {
            listed
                .entry
                .map_err(|what| format!("{}:{}: {what}", list.display(), listed.line).into())
        });
        let poses = poses.collect::<Result<Vec<Pose>, Failure>>()?;
        let mut case = Self::new(
            &name,
            files::mesh(folder, "a")?,
            files::mesh(folder, "b")?,
            poses,
        );
        case.known = known(&folder.join("truth.csv"), "pairs", case.poses.len())?;
        case.distances = known(
            &folder.join("truth_distance.csv"),
            "distance",
            case.poses.len(),
        )?;
        Ok(case)
    }

    /// Two mesh files at poses that are made for them: near contact, some in contact and some free, and at random. Writes the
    /// poses to the folder.
    pub fn between(
        files: [&Path; 2],
        quick: bool,
        folder: &Path,
        complain: &dyn Fn(&dyn Display),
    ) -> Result<Self, Failure> {
        let [a, b] = files.map(|file| {
            let Loaded { mesh, notices, .. } = punctual_io::load(file)?;
            notices
                .iter()
                .for_each(|notice| complain(&notice.in_file(file)));
            Ok::<_, Failure>(mesh)
        });
        let stem = |file: &Path| {
            let file = file.file_name().unwrap_or_default().to_string_lossy();
            let file = Path::new(file.trim_end_matches(".gz"));
            file.file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned()
        };
        let name = files.map(stem).join("_").replace(',', "_");
        let mut case = Self::new(&name, a?, b?, Vec::new());
        let [near, anywhere] = if quick { [28, 4] } else { [84, 16] };
        let mut approach = Approach::new(&case.a, &case.b, 1);
        let mut poses = approach::contact(&mut approach, near, false, &approach::OFFSETS)?;
        poses.extend(approach::random(&mut approach, anywhere)?);
        let mut list = Vec::new();
        for pose in &poses {
            approach::print(pose, &mut list)?;
        }
        report::write(&folder.join(format!("{name}_poses.txt")), list)?;
        case.poses = poses;
        Ok(case)
    }

    /// Length that offsets are measured by: the box diagonal of the smaller mesh.
    pub fn size(&self) -> f64 {
        diagonal(self.a.mesh()).min(diagonal(self.b.mesh()))
    }

    /// The boxes of the meshes along A's axes.
    pub fn boxes(&self, pose: &Pose) -> [Aabb; 2] {
        let (a, b) = (self.a.mesh().aabb(), self.b.mesh().aabb());
        let (center, half) = (pose.transform_point(b.center()), b.extents() * 0.5);
        let r = pose.rotation();
        let half = r.x_axis.abs() * half.x + r.y_axis.abs() * half.y + r.z_axis.abs() * half.z;
        [a, Aabb::new(center - half, center + half)]
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
            let coordinates = (0..mesh.len())
                .flat_map(|i| mesh.triangle(i))
                .flat_map(|v| v.to_array());
            coordinates.for_each(|x| add(x.to_bits()));
        }
        self.poses
            .iter()
            .flat_map(Pose::to_row_major)
            .for_each(|x| add(x.to_bits()));
        hash
    }
}

/// A column of a table with a line for each pose; empty without the file.
fn known<T: FromStr>(file: &Path, name: &str, poses: usize) -> Result<Vec<T>, Failure> {
    if !file.exists() {
        return Ok(Vec::new());
    }
    let text = report::read(file)?;
    let mut lines = text.lines();
    let mut header = lines.next().unwrap_or_default().split(',');
    let column = header.position(|title| title == name);
    let column = column.ok_or_else(|| format!("{}: no column {name}", file.display()))?;
    let value = |line: &str| line.split(',').nth(column)?.trim().parse().ok();
    let values = lines.zip(2..).map(|(line, number)| {
        value(line).ok_or_else(|| {
            format!("{}:{number}: no number in column {name}", file.display()).into()
        })
    });
    let values = values.collect::<Result<Vec<T>, Failure>>()?;
    if values.len() != poses {
        return Err(format!("{}: not a line for each pose", file.display()).into());
    }
    Ok(values)
}
