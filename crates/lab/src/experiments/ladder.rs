//! Ladders: one shape at rising resolution.

use std::path::Path;

use punctual::glam::Vec3;
use punctual::{Mesh, shapes};

use crate::report::Failure;

/// A shape's meshes, from few triangles to many.
pub struct Ladder {
    pub name: String,
    pub meshes: Vec<Mesh>,
}

/// Generated shapes: round, flat-sided, thin, tangled, toothed, open.
pub fn built_in(quick: bool) -> Vec<Ladder> {
    // Side lengths in segments double from rung to rung, so triangles become four times as many.
    let steps = if quick { 3 } else { 5 };
    let rungs = |name: &str, make: &dyn Fn(u32) -> Mesh| Ladder {
        name: name.to_owned(),
        meshes: (0..steps).map(|i| make(1 << i)).collect(),
    };
    vec![
        rungs("sphere", &|k| shapes::icosphere(2 + k.ilog2())),
        rungs("box", &|k| shapes::cuboid(Vec3::new(1.0, 0.7, 0.4), 6 * k)),
        rungs("torus", &|k| shapes::torus(1.0, 0.3, 20 * k)),
        rungs("knot", &|k| shapes::torus_knot(2, 3, 0.1, 48 * k)),
        rungs("gear", &|k| shapes::gear(12, k)),
        rungs("hills", &|k| shapes::height_field(16 * k, 1)),
    ]
}

/// The meshes of files separated by commas, sorted by their number of triangles; named by what the file names begin with.
pub fn load(files: &str) -> Result<Ladder, Failure> {
    let files: Vec<&Path> = files.split(',').map(Path::new).collect();
    let mut meshes = files
        .iter()
        .map(|file| Ok(punctual_io::load(file)?.mesh))
        .collect::<Result<Vec<Mesh>, punctual_io::FileError>>()?;
    meshes.sort_by_key(Mesh::len);
    if meshes.windows(2).any(|pair| pair[0].len() == pair[1].len()) || meshes.len() < 2 {
        return Err(format!(
            "{}: a ladder needs two sizes or more, all different",
            files[0].display()
        )
        .into());
    }
    let stems: Vec<_> = files
        .iter()
        .map(|file| file.file_stem().unwrap_or_default().to_string_lossy())
        .collect();
    let common = stems.iter().fold(stems[0].to_string(), |common, stem| {
        let both = common.chars().zip(stem.chars());
        both.take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
    });
    let name: String = common
        .chars()
        .filter(|c| !c.is_control() && *c != ',')
        .collect();
    let name = name.trim_end_matches(|c: char| !c.is_alphabetic());
    Ok(Ladder {
        name: if name.is_empty() {
            "meshes".to_owned()
        } else {
            name.to_owned()
        },
        meshes,
    })
}
