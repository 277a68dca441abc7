//! The files of a scene: `scene.txt`, `poses.csv`, `truth_pairs.csv`, each of the last two also as `.gz`.
//!
//! `scene.txt` has the lines `mesh ID FILE` and `body INDEX MESH static|moving [IMPORTANCE]`; `poses.csv` the columns
//! `frame,body,px,py,pz,qw,qx,qy,qz`; `truth_pairs.csv` the columns `frame,a,b`, a < b, of the pairs that intersect.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::GzDecoder;
use punctual::glam::{DQuat, DVec3};
use punctual::{BuildOptions, Pose, Tree};
use punctual_io::FileError;
use punctual_io::text::{decode, fields, lines, number, shorten};
use punctual_scene::{Body, Replay};

use crate::input::MeshArgs;

/// A scene and its motion.
#[derive(Default)]
pub struct Recording {
    /// By the numbers in the file.
    pub bodies: Vec<Body>,
    /// The file of each body's mesh, without its folder.
    pub meshes: Vec<String>,
    /// The poses of each frame, one for each body.
    pub frames: Vec<Vec<Pose>>,
    /// The pairs of each frame that intersect, ascending; if there is such a file.
    pub truth: Option<Vec<Vec<[u32; 2]>>>,
    /// A file of the calls of a scene, in place of all this.
    pub calls: Option<PathBuf>,
}

impl Recording {
    pub fn load(folder: &Path, meshes: &MeshArgs) -> Result<Self, FileError> {
        if folder.is_file() {
            return Ok(Self {
                calls: Some(folder.to_owned()),
                ..Self::default()
            });
        }
        let list = folder.join("scene.txt");
        let parts = parts(&list, folder, meshes)?;
        let poses = either(folder, "poses.csv").unwrap_or_else(|| folder.join("poses.csv"));
        let frames = frames(&poses, parts.len())?;
        let first = frames
            .first()
            .ok_or_else(|| FileError::at_line(&poses, 1, "no frame in it"))?;
        let bodies = parts.iter().zip(first).map(|(part, &pose)| {
            let make = if part.fixed {
                Body::fixed
            } else {
                Body::moving
            };
            make(Arc::clone(&part.tree), pose).importance(part.importance)
        });
        let bodies = bodies.collect();
        let meshes = parts.iter().map(|part| part.mesh.clone()).collect();
        let truth = either(folder, "truth_pairs.csv")
            .map(|file| truth(&file, frames.len(), parts.len()))
            .transpose()?;
        Ok(Self {
            bodies,
            meshes,
            frames,
            truth,
            calls: None,
        })
    }

    /// Begins with the calls of the file, if it is one.
    pub fn replay(&self) -> Result<Option<Replay<Box<dyn Read>>>, FileError> {
        let open = |file: &PathBuf| {
            let error = |error| FileError::from_io(file, &error);
            Ok(Replay::new(unpacked(file).map_err(error)?))
        };
        self.calls.as_ref().map(open).transpose()
    }
}

/// The file of this name, plain or packed.
fn either(folder: &Path, name: &str) -> Option<PathBuf> {
    [name.to_owned(), format!("{name}.gz")]
        .map(|name| folder.join(name))
        .into_iter()
        .find(|file| file.is_file())
}

/// The content of a file, unpacked if its name says that it is packed.
fn unpacked(file: &Path) -> io::Result<Box<dyn Read>> {
    let content = File::open(file)?;
    Ok(
        if file.extension().is_some_and(|extension| extension == "gz") {
            Box::new(BufReader::new(GzDecoder::new(content)))
        } else {
            Box::new(BufReader::new(content))
        },
    )
}

fn read(file: &Path) -> Result<String, FileError> {
    let read = || {
        let mut bytes = Vec::new();
        unpacked(file)?.read_to_end(&mut bytes)?;
        Ok(decode(&bytes).into_owned())
    };
    read().map_err(|error| FileError::from_io(file, &error))
}

/// A body without its pose.
struct Part {
    tree: Arc<Tree>,
    mesh: String,
    fixed: bool,
    importance: f32,
}

fn parts(list: &Path, folder: &Path, meshes: &MeshArgs) -> Result<Vec<Part>, FileError> {
    let text = read(list)?;
    let mut trees = HashMap::new();
    let mut parts = Vec::new();
    for (line, at) in lines(&text).zip(1..) {
        let fault = |what: String| FileError::at_line(list, at, what);
        match fields(line)[..] {
            [] => {}
            ["mesh", id, file] => {
                let tree = Tree::with_options(
                    meshes.load(&folder.join(file))?,
                    &BuildOptions::default().extremes(true),
                );
                let name = Path::new(file).file_name().unwrap_or(file.as_ref());
                trees.insert(
                    id.to_owned(),
                    (Arc::new(tree), name.to_string_lossy().into_owned()),
                );
            }
            [
                "body",
                index,
                mesh,
                kind @ ("static" | "moving"),
                ref rest @ ..,
            ] if rest.len() < 2 => {
                if index.parse() != Ok(parts.len()) {
                    return Err(fault(format!(
                        "body {}, must be {}",
                        shorten(index),
                        parts.len()
                    )));
                }
                let (tree, mesh) = trees
                    .get(mesh)
                    .ok_or_else(|| fault(format!("no mesh {}", shorten(mesh))))?;
                let importance = rest
                    .first()
                    .map_or(Ok(0.0), |importance| number(importance))
                    .map_err(fault)? as f32;
                parts.push(Part {
                    tree: Arc::clone(tree),
                    mesh: mesh.clone(),
                    fixed: kind == "static",
                    importance,
                });
            }
            _ => {
                return Err(fault(
                    "must be `mesh ID FILE` or `body INDEX MESH static|moving [IMPORTANCE]`"
                        .to_owned(),
                ));
            }
        }
    }
    Ok(parts)
}

/// The lines of a table of numbers below its header, `N` columns each.
fn table<const N: usize>(file: &Path) -> Result<Vec<(usize, [f64; N])>, FileError> {
    let text = read(file)?;
    let lines = lines(&text)
        .zip(1..)
        .skip(1)
        .filter(|(line, _)| !line.trim().is_empty());
    let parse = |(line, at): (&str, usize)| {
        let mut numbers = [0.0; N];
        let mut columns = line.split(',');
        for slot in &mut numbers {
            let column = columns
                .next()
                .ok_or_else(|| format!("fewer than {N} columns"));
            *slot = column
                .and_then(|column| number(column.trim()))
                .map_err(|what| FileError::at_line(file, at, what))?;
        }
        Ok((at, numbers))
    };
    lines.map(parse).collect()
}

/// A column that counts something.
fn index(number: f64, end: usize) -> Option<usize> {
    let index = number as usize;
    (index as f64 == number && index < end).then_some(index)
}

fn frames(file: &Path, bodies: usize) -> Result<Vec<Vec<Pose>>, FileError> {
    let mut frames: Vec<Vec<Pose>> = Vec::new();
    for (line, [frame, body, px, py, pz, qw, qx, qy, qz]) in table(file)? {
        let fault = |what: String| FileError::at_line(file, line, what);
        let expected = match frames.last() {
            Some(last) if last.len() < bodies => (frames.len() - 1, last.len()),
            _ => (frames.len(), 0),
        };
        if (frame, body) != (expected.0 as f64, expected.1 as f64) {
            return Err(fault(format!(
                "frame {frame}, body {body}: must be frame {}, body {}",
                expected.0, expected.1
            )));
        }
        let pose = Pose::from_quat(DQuat::from_xyzw(qx, qy, qz, qw), DVec3::new(px, py, pz));
        let pose = pose.map_err(|error| fault(error.to_string()))?;
        if body == 0.0 {
            frames.push(Vec::with_capacity(bodies));
        }
        frames
            .last_mut()
            .into_iter()
            .for_each(|last| last.push(pose));
    }
    match frames.last() {
        Some(last) if last.len() < bodies => {
            let what = format!("the last frame has {} of {bodies} bodies", last.len());
            Err(FileError::at_line(file, 1 + frames.len(), what))
        }
        _ => Ok(frames),
    }
}

fn truth(file: &Path, frames: usize, bodies: usize) -> Result<Vec<Vec<[u32; 2]>>, FileError> {
    let mut truth = vec![Vec::new(); frames];
    for (line, [frame, a, b]) in table(file)? {
        let pair = [a, b].map(|body| index(body, bodies).map(|body| body as u32));
        let (Some(frame), [Some(a), Some(b)]) = (index(frame, frames), pair) else {
            return Err(FileError::at_line(file, line, "no such frame or body"));
        };
        truth[frame].push([a.min(b), a.max(b)]);
    }
    truth.iter_mut().for_each(|pairs| pairs.sort_unstable());
    Ok(truth)
}
