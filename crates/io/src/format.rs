//! Which format a file has.

use std::path::Path;

use crate::ReadError;
use crate::text::{decode, lines, without_comment};

/// A file format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ: `v` and `f`, with polygons, continued lines and relative indices; coordinates in f64.
    Obj,
    /// STL, ASCII or binary; coordinates in f32.
    Stl,
    /// PLY, ASCII or binary of both byte orders; coordinates as the file declares them.
    Ply,
    /// glTF, binary (`.glb`) or JSON text (`.gltf`): the triangles of the default scene, moved by their nodes in f64.
    Gltf,
    /// COLLADA (`.dae`): the meshes of the scene, moved by their nodes in f64, in metres. Needs the feature `collada`.
    Collada,
    /// OFF in text; coordinates in f64.
    Off,
}

impl Format {
    /// The file name extensions that are read, in lower case; each also with `.gz` behind it.
    pub const EXTENSIONS: [&str; 7] = ["obj", "stl", "ply", "off", "glb", "gltf", "dae"];

    /// The format that the extension of a file name stands for, upper or lower case, also before `.gz`.
    ///
    /// # Errors
    /// If it stands for none.
    pub fn of(file: &Path) -> Result<Self, ReadError> {
        match extension(file).as_str() {
            "obj" => Ok(Self::Obj),
            "stl" => Ok(Self::Stl),
            "ply" => Ok(Self::Ply),
            "off" => Ok(Self::Off),
            "dae" => Ok(Self::Collada),
            "glb" | "gltf" => Ok(Self::Gltf),
            _ => {
                let known = Self::EXTENSIONS.map(|name| format!(".{name}")).join(", ");
                Err(ReadError::new(format!(
                    "no mesh format by its extension; use one of {known}, or these with .gz"
                )))
            }
        }
    }

    /// The format that the content of a file looks like.
    pub(crate) fn of_content(bytes: &[u8]) -> Result<Self, ReadError> {
        let start = decode(&bytes[..bytes.len().min(1 << 10)]);
        let start = start.trim_start();
        let mut words =
            lines(start).flat_map(|line| without_comment(line).split_ascii_whitespace());
        let keyword = words.next().unwrap_or_default();
        let is_statement = |line: &str| {
            matches!(
                line.split_ascii_whitespace().next(),
                Some("v" | "f" | "mtllib" | "o")
            )
        };
        match () {
            () if keyword == "ply" => Ok(Self::Ply),
            () if start.starts_with("glTF") || start.starts_with('{') => Ok(Self::Gltf),
            () if start.starts_with('<') && start.contains("<COLLADA") => Ok(Self::Collada),
            () if keyword.contains("OFF") || keyword == "off" => Ok(Self::Off),
            () if crate::stl::is_likely(bytes) => Ok(Self::Stl),
            () if lines(&decode(bytes)).any(is_statement) => Ok(Self::Obj),
            () => Err(ReadError::new("no mesh format by its content")),
        }
    }
}

/// The extension of a file name in lower case; of `.gz` files, that before it.
pub(crate) fn extension(file: &Path) -> String {
    let is_packed = file
        .extension()
        .is_some_and(|name| name.eq_ignore_ascii_case("gz"));
    let name = if is_packed {
        file.file_stem()
    } else {
        file.file_name()
    };
    let extension = Path::new(name.unwrap_or_default()).extension();
    extension
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}
