//! STL, ASCII and binary, by `stl_io`, in f32 as the format defines it.
//!
//! Three things the crate leaves to us. It takes any file that begins with `solid ` for ASCII, though many binary
//! ones do: here the size decides. It stops after the first solid of an ASCII file: here all are read. And it knows
//! no line numbers: it is handed one line at a time, so the lines handed out are the lines it has come to.

use std::cell::Cell;
use std::io::{self, Cursor, Read, Seek, SeekFrom};

use stl_io::IndexedMesh;

use super::{Fault, Surface};

const HEADER: usize = 84;
const BYTES_PER_TRIANGLE: usize = 50;

pub fn parse(mut bytes: Vec<u8>) -> Result<Surface, Fault> {
    let count = bytes.get(HEADER - 4..HEADER).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let expected = count.map(|count| HEADER + BYTES_PER_TRIANGLE * count);
    if expected == Some(bytes.len()) {
        bytes[0] = 0;
        let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| Fault::new(error.to_string()))?;
        let mut surface = Surface::default();
        append(&mut surface, mesh)?;
        return Ok(surface);
    }
    let start = bytes.get(..5).unwrap_or_default();
    // A damaged binary file may begin with `solid` too; but no text has zeros.
    if start.eq_ignore_ascii_case(b"solid") && !bytes.contains(&0) {
        return parse_ascii(&uniform(&bytes));
    }
    Err(Fault::new(match (count, expected) {
        (Some(count), Some(expected)) => {
            format!("binary STL of {count} triangles has {expected} bytes, this file has {}", bytes.len())
        }
        _ => format!("neither ASCII STL nor, with {} bytes, a binary one", bytes.len()),
    }))
}

fn parse_ascii(text: &[u8]) -> Result<Surface, Fault> {
    let line = Cell::new(0);
    let mut source = Lines { rest: text, line: &line, restart: (text, 0) };
    let mut surface = Surface::default();
    while !source.rest.trim_ascii().is_empty() {
        source.skip_blank_lines();
        if !source.rest.starts_with(b"solid ") {
            return Err(Fault::at(line.get() + 1, "expected `solid` or the end of the file"));
        }
        source.restart = (source.rest, line.get());
        let solid = stl_io::read_stl(&mut source);
        append(&mut surface, solid.map_err(|error| Fault::at(line.get(), error.to_string()))?)?;
    }
    Ok(surface)
}

/// Text as `stl_io` wants it, line by line: lower case, a blank after `solid`, and normals that are numbers, because
/// some programs write `nan` for those of degenerate triangles. Normals are not used.
fn uniform(text: &[u8]) -> Vec<u8> {
    let mut uniform = Vec::with_capacity(text.len() + 64);
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        let lower = line.trim_ascii().to_ascii_lowercase();
        if lower.starts_with(b"solid") {
            uniform.extend_from_slice(b"solid ");
        } else if lower.starts_with(b"facet normal ") {
            uniform.extend_from_slice(b"facet normal 0 0 0");
        } else {
            uniform.extend_from_slice(&lower);
        }
        uniform.push(b'\n');
    }
    uniform
}

fn append(surface: &mut Surface, mesh: IndexedMesh) -> Result<(), Fault> {
    let base = surface.vertices.len();
    u32::try_from(base + mesh.vertices.len()).map_err(|_| Fault::new("more than 2^32 vertices"))?;
    surface.vertices.extend(mesh.vertices.iter().map(|vertex| vertex.0.map(f64::from)));
    let corners = mesh.faces.iter().map(|face| face.vertices.map(|corner| (base + corner) as u32));
    surface.triangles.extend(corners);
    Ok(())
}

/// A source that gives at most one line a read.
struct Lines<'a> {
    rest: &'a [u8],
    line: &'a Cell<usize>,
    /// Where the solid begins: `stl_io` looks at its first line, then rewinds.
    restart: (&'a [u8], usize),
}

impl Lines<'_> {
    fn first_line(&self) -> &[u8] {
        self.rest.split_inclusive(|&byte| byte == b'\n').next().unwrap_or_default()
    }

    fn skip_blank_lines(&mut self) {
        while !self.rest.is_empty() && self.first_line().trim_ascii().is_empty() {
            self.rest = &self.rest[self.first_line().len()..];
            self.line.set(self.line.get() + 1);
        }
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let line = self.first_line();
        let length = line.len().min(buffer.len());
        buffer[..length].copy_from_slice(&line[..length]);
        if length == line.len() && length > 0 {
            self.line.set(self.line.get() + 1);
        }
        self.rest = &self.rest[length..];
        Ok(length)
    }
}

impl Seek for Lines<'_> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        match position {
            SeekFrom::Start(0) => {
                self.rest = self.restart.0;
                self.line.set(self.restart.1);
                Ok(0)
            }
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}
