//! Wavefront OBJ, read here and not by a crate: the maintained ones keep f32, or renumber the vertices, and none says
//! on which line an index or a coordinate is at fault. Exact f64 and the line are what this crate promises.
//!
//! Read are `v` and `f`, with continued lines, relative indices, `v/vt/vn` corners and polygons. Statements that say
//! nothing about the surface are skipped; those that would add to it unread, such as curved surfaces, are errors. The text
//! is gone through twice, vertices first, since a face may name vertices that come after it.

use std::borrow::Cow;

use crate::text::{number, shorten, without_comment};
use crate::{Place, ReadError, Surface, polygon};

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

pub(crate) fn parse(bytes: &[u8]) -> Result<Surface, ReadError> {
    // Names and comments may be in any encoding; statements are ASCII.
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut surface = Surface::default();
    for (line, statement) in statements(text) {
        let mut fields = statement.split_ascii_whitespace();
        match fields.next() {
            Some("v") => {
                let vertex = vertex(fields).map_err(|what| ReadError::at_line(line, what))?;
                surface.vertices.push(vertex);
                surface.places.push(Place::Line(line));
            }
            None | Some("f" | "fo") => {}
            Some(skipped) if SKIPPED.contains(&skipped) => {}
            Some(other) => return Err(ReadError::at_line(line, format!("unknown statement `{}`", shorten(other)))),
        }
    }
    faces(text, &mut surface)?;
    Ok(surface)
}

/// The lines of a text with the numbers of their first ones, continued lines in one, without comments.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().map(without_comment).zip(1..);
    std::iter::from_fn(move || {
        let (first, line) = lines.next()?;
        let mut statement = Cow::Borrowed(first);
        while statement.ends_with('\\') {
            statement.to_mut().pop();
            let Some((next, _)) = lines.next() else { break };
            statement.to_mut().push(' ');
            statement.to_mut().push_str(next);
        }
        Some((line, statement))
    })
}

/// Three coordinates; a weight or a colour may follow.
fn vertex<'a>(fields: impl Iterator<Item = &'a str>) -> Result<[f64; 3], String> {
    let mut numbers = [0.0; 7];
    let mut count = 0;
    for field in fields {
        let slot = numbers.get_mut(count).ok_or("vertex of more than 7 numbers")?;
        *slot = number(field)?;
        count += 1;
    }
    match count {
        0..3 => Err(format!("vertex of {count} coordinates, must be 3")),
        _ => Ok([numbers[0], numbers[1], numbers[2]]),
    }
}

fn faces(text: &str, surface: &mut Surface) -> Result<(), ReadError> {
    let Surface { vertices, triangles, .. } = surface;
    let mut corners = Vec::new();
    let mut before = 0;
    for (line, statement) in statements(text) {
        let mut fields = statement.split_ascii_whitespace();
        match fields.next() {
            Some("v") => before += 1,
            Some("f" | "fo") => {
                corners.clear();
                let read = fields.try_for_each(|field| {
                    corners.push(corner(field, before, vertices.len())?);
                    Ok(())
                });
                read.and_then(|()| polygon::fill(&corners, vertices, triangles))
                    .map_err(|what| ReadError::at_line(line, what))?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 0; `before`: vertices above the line, from which
/// negative indices count back.
fn corner(field: &str, before: usize, count: usize) -> Result<u32, String> {
    let mut parts = field.split('/');
    let index = parts.next().and_then(|index| index.parse::<i64>().ok());
    let others = parts.by_ref().take(2).all(|index| index.is_empty() || index.parse::<i64>().is_ok());
    let (Some(index), true, None) = (index, others, parts.next()) else {
        return Err(format!("`{}` is no vertex index", shorten(field)));
    };
    let vertex = if index > 0 { index - 1 } else { (before as i64).saturating_add(index) };
    match u32::try_from(vertex) {
        Ok(vertex) if index != 0 && (vertex as usize) < count => Ok(vertex),
        _ if index < 0 => Err(format!("vertex index {index} is out of range: {before} vertices above")),
        _ => Err(format!("vertex index {index} is out of range: {count} vertices, counted from 1")),
    }
}
