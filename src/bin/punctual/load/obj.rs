//! Wavefront OBJ, read here and not by a crate: the maintained ones keep f32, or renumber the vertices, and none says
//! on which line an index or a coordinate is at fault. Exact f64 and the line are what this program promises.
//!
//! Read are `v` and `f`, with continued lines, negative indices, `v/vt/vn` corners and polygons. Statements that say
//! nothing about the surface are skipped; those that would add to it unread, such as curved surfaces, are errors.

use std::borrow::Cow;

use super::{Fault, Surface};
use crate::text::{number, shorten, without_comment};

const SKIPPED: [&str; 21] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "l",
    "p",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
];

#[derive(Default)]
struct Reader {
    surface: Surface,
    corners: Vec<u32>,
    /// Indices not below the number of vertices read so far, with their lines.
    ahead: Vec<(usize, i64)>,
}

pub fn parse(bytes: &[u8]) -> Result<Surface, Fault> {
    // Names and comments may be in any encoding; statements are ASCII.
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut reader = Reader::default();
    let mut lines = text.lines().map(without_comment).zip(1..);
    while let Some((first, line)) = lines.next() {
        let mut statement = Cow::Borrowed(first);
        while statement.ends_with('\\') {
            statement.to_mut().pop();
            let Some((next, _)) = lines.next() else { break };
            statement.to_mut().push(' ');
            statement.to_mut().push_str(next);
        }
        reader.take(line, &statement)?;
    }
    reader.finish()
}

impl Reader {
    fn take(&mut self, line: usize, statement: &str) -> Result<(), Fault> {
        let mut fields = statement.split_ascii_whitespace();
        match fields.next() {
            Some("v") => self.vertex(line, fields),
            Some("f" | "fo") => self.face(line, fields),
            None => Ok(()),
            Some(skipped) if SKIPPED.contains(&skipped) => Ok(()),
            Some(other) => Err(Fault::at(line, format!("unknown statement `{}`", shorten(other)))),
        }
    }

    /// Three coordinates; a weight or a colour may follow.
    fn vertex<'a>(&mut self, line: usize, fields: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let mut numbers = [0.0; 7];
        let mut count = 0;
        for field in fields {
            let slot = numbers.get_mut(count).ok_or_else(|| Fault::at(line, "vertex of more than 7 numbers"))?;
            *slot = number(field).map_err(|what| Fault::at(line, what))?;
            count += 1;
        }
        if count < 3 {
            return Err(Fault::at(line, format!("vertex of {count} coordinates, must be 3")));
        }
        self.surface.vertices.push([numbers[0], numbers[1], numbers[2]]);
        self.surface.vertex_lines.push(line);
        Ok(())
    }

    fn face<'a>(&mut self, line: usize, fields: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for field in fields {
            corners.push(self.corner(line, field)?);
        }
        if corners.len() < 3 {
            return Err(Fault::at(line, format!("face of {} corners, must be 3 or more", corners.len())));
        }
        self.surface.push_polygon(&corners);
        self.corners = corners;
        Ok(())
    }

    /// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 0.
    fn corner(&mut self, line: usize, field: &str) -> Result<u32, Fault> {
        let position = field.split_once('/').map_or(field, |(position, _)| position);
        let index: i64 =
            position.parse().map_err(|_| Fault::at(line, format!("`{}` is no vertex index", shorten(field))))?;
        let count = self.surface.vertices.len() as i64;
        let vertex = if index > 0 { index - 1 } else { count.saturating_add(index) };
        if index > count {
            self.ahead.push((line, index));
        }
        if index == 0 || vertex < 0 {
            return Err(out_of_range(line, index, self.surface.vertices.len()));
        }
        u32::try_from(vertex).map_err(|_| out_of_range(line, index, self.surface.vertices.len()))
    }

    fn finish(self) -> Result<Surface, Fault> {
        let count = self.surface.vertices.len();
        match self.ahead.into_iter().find(|&(_, index)| index > count as i64) {
            Some((line, index)) => Err(out_of_range(line, index, count)),
            None => Ok(self.surface),
        }
    }
}

fn out_of_range(line: usize, index: i64, count: usize) -> Fault {
    Fault::at(line, format!("vertex index {index} is out of range: {count} vertices, counted from 1"))
}
