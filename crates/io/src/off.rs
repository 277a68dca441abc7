//! OFF, in text: counts, a line for each vertex, a line for each face.
//!
//! Vertices may have normals, colours or texture coordinates behind the coordinates (`NOFF`, `COFF`, `STOFF`), and
//! faces a
//! colour. The keyword may be missing, or stand before the counts on their line, with a blank or without, as some
//! collections
//! have it.

use crate::notice::Notices;
use crate::text::{decode, lines, number, shorten, without_comment, without_padding};
use crate::{Place, ReadError, Surface, polygon};

pub(crate) fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Surface, ReadError> {
    let text = decode(bytes);
    let text = without_padding(&text, notices);
    let mut lines = lines(text)
        .zip(1..)
        .map(|(line, at)| (without_comment(line).trim_ascii(), at));
    let mut next = |what: &str| {
        let line = lines.find(|(line, _)| !line.is_empty());
        line.ok_or_else(|| ReadError::new(format!("end of file before {what}")))
    };
    let (mut line, mut at) = next("the counts")?;
    if let Some(rest) = after_keyword(line)? {
        (line, at) = if rest.is_empty() {
            next("the counts")?
        } else {
            (rest, at)
        };
    }
    let [vertices, faces] =
        counts(line, bytes.len()).map_err(|what| ReadError::at_line(at, what))?;
    let mut surface = Surface::default();
    for _ in 0..vertices {
        let (line, at) = next("the last vertex")?;
        surface
            .vertices
            .push(vertex(line).map_err(|what| ReadError::at_line(at, what))?);
        surface.places.push(Place::Line(at));
    }
    let Surface {
        vertices,
        triangles,
        ..
    } = &mut surface;
    for _ in 0..faces {
        let (line, at) = next("the last face")?;
        let corners = corners(line, vertices.len()).map_err(|what| ReadError::at_line(at, what))?;
        if let Some(oddity) = polygon::fill(&corners, vertices, triangles) {
            notices.add(Place::Line(at), oddity);
        }
    }
    if let Ok((_, at)) = next("the end") {
        notices.add(Place::Line(at), "lines after the last face passed over");
    }
    Ok(surface)
}

/// What stands behind the keyword, on its line; nothing if there is none.
fn after_keyword(line: &str) -> Result<Option<&str>, ReadError> {
    let Some(start) = line.find("OFF").or_else(|| line.find("off")) else {
        return Ok(None);
    };
    let (prefix, rest) = (&line[..start], line[start + 3..].trim_ascii());
    if !prefix.chars().all(|c| "STCN4n".contains(c)) {
        return Ok(None);
    }
    if prefix.contains(['4', 'n']) {
        return Err(ReadError::needs("OFF of more than 3 dimensions"));
    }
    if rest.starts_with("BINARY") {
        return Err(ReadError::needs("binary OFF"));
    }
    Ok(Some(rest))
}

/// How many vertices and faces there are, no more than a file of so many bytes can hold.
fn counts(line: &str, bytes: usize) -> Result<[usize; 2], String> {
    let mut fields = line.split_ascii_whitespace();
    let mut count = || {
        let field = fields
            .next()
            .ok_or("must be the numbers of vertices and faces")?;
        let count = field
            .parse()
            .map_err(|_| format!("`{}` is no number of vertices or faces", shorten(field)))?;
        if count > bytes {
            Err(format!(
                "{count} vertices or faces do not fit into {bytes} bytes"
            ))
        } else {
            Ok(count)
        }
    };
    Ok([count()?, count()?])
}

fn vertex(line: &str) -> Result<[f64; 3], String> {
    let mut fields = line.split_ascii_whitespace();
    let mut vertex = [0.0; 3];
    for (count, slot) in vertex.iter_mut().enumerate() {
        *slot = number(
            fields
                .next()
                .ok_or_else(|| format!("vertex of {count} coordinates, must be 3"))?,
        )?;
    }
    Ok(vertex)
}

/// The corners of a face: their number, then their indices, counted from 0; a colour may follow.
fn corners(line: &str, vertices: usize) -> Result<Vec<u32>, String> {
    let mut fields = line.split_ascii_whitespace();
    let mut index = || -> Result<usize, String> {
        let field = fields
            .next()
            .ok_or("fewer indices than the face has corners")?;
        field
            .parse()
            .map_err(|_| format!("`{}` is no vertex index", shorten(field)))
    };
    let corner = |index: usize| match index < vertices {
        true => Ok(index as u32),
        false => Err(format!(
            "vertex index {index} is out of range: {vertices} vertices, counted from 0"
        )),
    };
    (0..index()?).map(|_| corner(index()?)).collect()
}
