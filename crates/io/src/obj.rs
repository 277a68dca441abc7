//! Wavefront OBJ, read here and not by a crate: the maintained ones keep f32, or renumber the vertices, and none says
//! on which line an index or a coordinate is at fault. Exact f64 and the line are what this crate promises.
//!
//! Read are `v` and `f`, with continued lines, relative indices, `v/vt/vn` corners and polygons. Statements that say
//! nothing about the surface are skipped; others are passed over with a notice. The text is gone through twice,
//! vertices
//! first, since a face may name vertices that come after it.

use std::borrow::Cow;

use crate::notice::Notices;
use crate::text::{decode, lines, number, shorten, without_comment, without_padding};
use crate::{Place, ReadError, Surface, polygon};

/// Statements that say nothing about the surface.
const SKIPPED: [&str; 18] = [
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
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
];
/// Statements of curves and surfaces that are given by formulas.
const FREE_FORM: [&str; 4] = ["curv", "curv2", "surf", "cstype"];

pub(crate) fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Surface, ReadError> {
    // Names and comments may be in any encoding; statements are ASCII.
    let text = decode(bytes);
    let text = without_padding(&text, notices);
    let mut surface = Surface::default();
    let mut has_free_form = false;
    for (line, statement) in statements(text) {
        let mut fields = statement.split_ascii_whitespace();
        let place = Place::Line(line);
        match fields.next() {
            Some("v") => {
                let (vertex, is_plain) =
                    vertex(fields).map_err(|what| ReadError::at(place, what))?;
                surface.vertices.push(vertex);
                surface.places.push(place);
                if !is_plain {
                    notices.add(
                        place,
                        "fields after the coordinates of a vertex passed over",
                    );
                }
            }
            None | Some("f" | "fo") => {}
            Some(name @ ("l" | "p")) => {
                notices.add(place, format!("`{name}` passed over: it has no triangles"))
            }
            Some(skipped) if SKIPPED.contains(&skipped) => {}
            Some(name) => {
                has_free_form |= FREE_FORM.contains(&name);
                notices.add(
                    place,
                    format!("unknown statement `{}` passed over", shorten(name)),
                );
            }
        }
    }
    faces(text, &mut surface, notices)?;
    if surface.triangles.is_empty() && has_free_form {
        return Err(ReadError::needs("free-form geometry"));
    }
    Ok(surface)
}

/// The lines of a text with the numbers of their first ones, continued lines in one, without comments.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = lines(text).map(without_comment).zip(1..);
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

/// Three coordinates, and whether no more follows than a weight or a colour.
fn vertex<'a>(mut fields: impl Iterator<Item = &'a str>) -> Result<([f64; 3], bool), String> {
    let mut vertex = [0.0; 3];
    for (count, slot) in vertex.iter_mut().enumerate() {
        *slot = number(
            fields
                .next()
                .ok_or_else(|| format!("vertex of {count} coordinates, must be 3"))?,
        )?;
    }
    let mut rest = 0;
    let is_plain = fields
        .inspect(|_| rest += 1)
        .all(|field| field.parse::<f64>().is_ok());
    Ok((vertex, is_plain && rest <= 4))
}

fn faces(text: &str, surface: &mut Surface, notices: &mut Notices) -> Result<(), ReadError> {
    let Surface {
        vertices,
        triangles,
        ..
    } = surface;
    let mut corners = Vec::new();
    let mut before = 0;
    for (line, statement) in statements(text) {
        let mut fields = statement.split_ascii_whitespace();
        match fields.next() {
            Some("v") => before += 1,
            Some("f" | "fo") => {
                corners.clear();
                for field in fields {
                    let corner = corner(field, before, vertices.len());
                    corners.push(corner.map_err(|what| ReadError::at_line(line, what))?);
                }
                if let Some(oddity) = polygon::fill(&corners, vertices, triangles) {
                    notices.add(Place::Line(line), oddity);
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 0, whatever follows the slash; `before`:
/// vertices above the line, from which
/// negative indices count back.
fn corner(field: &str, before: usize, count: usize) -> Result<u32, String> {
    let index = field.split_once('/').map_or(field, |(index, _)| index);
    let index: i64 = index
        .parse()
        .map_err(|_| format!("`{}` is no vertex index", shorten(field)))?;
    let vertex = if index > 0 {
        index - 1
    } else {
        (before as i64).saturating_add(index)
    };
    match u32::try_from(vertex) {
        Ok(vertex) if index != 0 && (vertex as usize) < count => Ok(vertex),
        _ if index < 0 => Err(format!(
            "vertex index {index} is out of range: {before} vertices above"
        )),
        _ => Err(format!(
            "vertex index {index} is out of range: {count} vertices, counted from 1"
        )),
    }
}
