//! OFF, in text: a keyword, three counts, the vertices, the faces.
//!
//! Vertices may have normals, colours or texture coordinates behind the coordinates (`NOFF`, `COFF`, `STOFF`), and
//! faces a colour. The keyword may be missing, or stand before the counts on their line, with a blank or without, as
//! some collections have it. Most files have a line for each vertex and face. The format allows a line end wherever it
//! allows a blank, but behind a face's colour. A file that cannot be read line by line is read as [`Layout`] says.

use std::str::SplitAsciiWhitespace;

use crate::notice::Notices;
use crate::text::{decode, lines, number, shorten, without_comment, without_padding};
use crate::{Place, ReadError, Surface, polygon};

/// How vertices and faces stand in lines.
#[derive(Clone, Copy, PartialEq)]
enum Layout {
    /// Each on a line. What stands behind it on the line is no part of it.
    Lines,
    /// Each begins on a new line, and may go on in the following ones.
    Wrapped,
    /// Anywhere. A vertex has what its keyword says, and so many numbers for its colour; a face has no colour.
    Stream(usize),
}

pub(crate) fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Surface, ReadError> {
    let text = decode(bytes);
    let text = without_padding(&text, notices);
    let read = |layout| Reader::new(text, layout).surface(bytes.len());
    // Another layout must explain all of the file.
    let is_whole = |found: &Found| found.rest.is_none() && !found.surface.triangles.is_empty();
    let others = [Layout::Wrapped, Layout::Stream(4), Layout::Stream(3)];
    let found = read(Layout::Lines).or_else(|error| {
        let found = |layout| read(layout).ok().filter(is_whole);
        others.into_iter().find_map(found).ok_or(error)
    })?;
    for (at, oddity) in found.oddities {
        notices.add(Place::Line(at), oddity);
    }
    if let Some(at) = found.rest {
        notices.add(Place::Line(at), "lines after the last face passed over");
    }
    Ok(found.surface)
}

/// What a layout gives.
struct Found {
    surface: Surface,
    /// Faces that are out of order, with their lines.
    oddities: Vec<(usize, &'static str)>,
    /// The line after the last face, if there is one.
    rest: Option<usize>,
}

/// The fields of a text.
struct Reader<'t, I> {
    layout: Layout,
    lines: I,
    /// The rest of the line.
    fields: SplitAsciiWhitespace<'t>,
    /// The number of the line.
    at: usize,
}

impl<'t> Reader<'t, ()> {
    fn new(text: &'t str, layout: Layout) -> Reader<'t, impl Iterator<Item = (&'t str, usize)>> {
        let lines = lines(text).zip(1..);
        let lines = lines.map(|(line, at)| (without_comment(line).trim_ascii(), at));
        Reader {
            layout,
            lines: lines.filter(|(line, _)| !line.is_empty()),
            fields: "".split_ascii_whitespace(),
            at: 0,
        }
    }
}

impl<'t, I: Iterator<Item = (&'t str, usize)>> Reader<'t, I> {
    fn line(&mut self, before: &str) -> Result<&'t str, ReadError> {
        let line = self.lines.next();
        let (line, at) =
            line.ok_or_else(|| ReadError::new(format!("end of file before {before}")))?;
        (self.fields, self.at) = (line.split_ascii_whitespace(), at);
        Ok(line)
    }

    /// Goes to the next vertex or face.
    fn begin(&mut self, before: &str) -> Result<(), ReadError> {
        let is_within = self.fields.clone().next().is_some();
        match self.layout {
            Layout::Stream(_) if is_within => Ok(()),
            _ => self.line(before).map(drop),
        }
    }

    /// The next field of a vertex or face.
    fn field(&mut self) -> Option<&'t str> {
        let field = self.fields.next();
        if field.is_some() || self.layout == Layout::Lines {
            return field;
        }
        self.line("").ok()?;
        self.fields.next()
    }

    fn surface(mut self, bytes: usize) -> Result<Found, ReadError> {
        let mut behind = 0;
        let line = self.line("the counts")?;
        if let Some((prefix, rest)) = after_keyword(line)? {
            if let Layout::Stream(of_colour) = self.layout {
                let kinds = [("N", 3), ("C", of_colour), ("ST", 2)];
                let kinds = kinds.iter().filter(|(kind, _)| prefix.contains(kind));
                behind = kinds.map(|(_, numbers)| numbers).sum();
            }
            self.fields = rest.split_ascii_whitespace();
            if rest.is_empty() {
                self.line("the counts")?;
            }
        }
        let at_line = |at| move |what: String| ReadError::at_line(at, what);
        let [vertices, faces] = self.counts(bytes).map_err(at_line(self.at))?;
        let (mut surface, mut oddities) = (Surface::default(), Vec::new());
        for _ in 0..vertices {
            self.begin("the last vertex")?;
            let at = self.at;
            surface.vertices.push(self.vertex().map_err(at_line(at))?);
            surface.places.push(Place::Line(at));
            for _ in 0..behind {
                self.field();
            }
        }
        let Surface {
            vertices,
            triangles,
            ..
        } = &mut surface;
        for _ in 0..faces {
            self.begin("the last face")?;
            let at = self.at;
            let corners = self.corners(vertices.len()).map_err(at_line(at))?;
            let oddity = polygon::fill(&corners, vertices, triangles);
            oddities.extend(oddity.map(|oddity| (at, oddity)));
        }
        Ok(Found {
            surface,
            oddities,
            rest: self.begin("the end").ok().map(|()| self.at),
        })
    }

    /// How many vertices and faces there are, no more than a file of so many bytes can hold. The number of edges
    /// follows.
    fn counts(&mut self, bytes: usize) -> Result<[usize; 2], String> {
        let mut count = || {
            let field = self
                .field()
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
        let counts = [count()?, count()?];
        self.field();
        Ok(counts)
    }

    fn vertex(&mut self) -> Result<[f64; 3], String> {
        let mut vertex = [0.0; 3];
        for (count, slot) in vertex.iter_mut().enumerate() {
            let field = self.field();
            *slot =
                number(field.ok_or_else(|| format!("vertex of {count} coordinates, must be 3"))?)?;
        }
        Ok(vertex)
    }

    /// The corners of a face: their number, then their indices, counted from 0.
    fn corners(&mut self, vertices: usize) -> Result<Vec<u32>, String> {
        let mut index = || -> Result<usize, String> {
            let field = self
                .field()
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
}

/// The letters before the keyword and what stands behind it, on its line; nothing if there is none.
fn after_keyword(line: &str) -> Result<Option<(&str, &str)>, ReadError> {
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
    Ok(Some((prefix, rest)))
}
