//! PLY, ASCII and binary of both byte orders. Coordinates may be of any number type; `double` is kept.
//!
//! Read here and not by a crate: the maintained one refuses numbers such as `.25` and does not say where in a binary file a
//! fault is. Elements other than `vertex`, `face` and `tristrips` are skipped, and so are their properties other than
//! the
//! coordinates and the list of corners. In ASCII an element has a line; blank lines are skipped.

mod body;
mod header;

use crate::notice::Notices;
use crate::{Place, ReadError, Surface, polygon};
use body::Body;
use header::{Element, Header};

const AXES: [&str; 3] = ["x", "y", "z"];
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Strips of triangles, as scanners write them.
const STRIPS: &str = "tristrips";
/// -1 ends a strip, also where indices have no sign.
const STRIP_ENDS: [f64; 2] = [-1.0, u32::MAX as f64];

pub(crate) fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Surface, ReadError> {
    let header = Header::parse(bytes, notices)?;
    let is_there = |name: &str| header.elements.iter().any(|element| element.name == name);
    if !is_there("face") && !is_there(STRIPS) {
        let what = match is_there("range_grid") {
            true => "needs range grids, which is not supported",
            false => "the file has no element `face`",
        };
        notices.add(Place::Line(header.lines), what);
    }
    let mut body = Body::new(bytes, &header);
    let mut surface = Surface::default();
    let mut faces = Faces::default();
    for element in &header.elements {
        for _ in 0..element.count {
            let place = body.begin(element)?;
            match element.name.as_str() {
                "vertex" => {
                    surface.vertices.push(vertex(&mut body, element)?);
                    surface.places.push(place);
                }
                kind @ ("face" | STRIPS) => {
                    corners(&mut body, element, &mut faces.corners)?;
                    faces.ends.push(End {
                        corners: faces.corners.len(),
                        place,
                        is_strip: kind == STRIPS,
                    });
                }
                _ => element
                    .properties
                    .iter()
                    .try_for_each(|property| body.skip(property))?,
            }
            body.end(notices);
        }
    }
    body.finish(notices);
    faces.fill(&mut surface, notices)?;
    Ok(surface)
}

fn vertex(body: &mut Body<'_>, element: &Element) -> Result<[f64; 3], ReadError> {
    let mut vertex = [f64::NAN; 3];
    for property in &element.properties {
        match AXES.iter().position(|axis| *axis == property.name) {
            Some(axis) => vertex[axis] = body.number(property.kind)?,
            None => body.skip(property)?,
        }
    }
    Ok(vertex)
}

fn corners(
    body: &mut Body<'_>,
    element: &Element,
    corners: &mut Vec<f64>,
) -> Result<(), ReadError> {
    for property in &element.properties {
        match property.count {
            Some(count) if CORNER_LISTS.contains(&property.name.as_str()) => {
                for _ in 0..body.count(count)? {
                    corners.push(body.number(property.kind)?);
                }
            }
            _ => body.skip(property)?,
        }
    }
    Ok(())
}

/// Faces and strips as they stand in the file, where they may come before the vertices.
#[derive(Default)]
struct Faces {
    /// The corners of all of them, one after the other.
    corners: Vec<f64>,
    ends: Vec<End>,
}

struct End {
    /// Where the face or strip ends among the corners of all.
    corners: usize,
    /// Where it stands in the file.
    place: Place,
    is_strip: bool,
}

impl Faces {
    fn fill(&self, surface: &mut Surface, notices: &mut Notices) -> Result<(), ReadError> {
        let Surface {
            vertices,
            triangles,
            ..
        } = surface;
        let count = vertices.len();
        let index = |&corner: &f64| match corner >= 0.0 && corner < count as f64 {
            true => Ok(corner as u32),
            false => Err(format!(
                "vertex index {corner} is out of range: {count} vertices, counted from 0"
            )),
        };
        let mut start = 0;
        for &End {
            corners: end,
            place,
            is_strip,
        } in &self.ends
        {
            let corners = &self.corners[start..end];
            let parts = corners.split(|corner| is_strip && STRIP_ENDS.contains(corner));
            for part in parts {
                let indices: Result<Vec<u32>, String> = part.iter().map(index).collect();
                let indices = indices.map_err(|what| ReadError::at(place, what))?;
                if is_strip {
                    polygon::strip(&indices, vertices, triangles);
                } else if let Some(oddity) = polygon::fill(&indices, vertices, triangles) {
                    notices.add(place, oddity);
                }
            }
            start = end;
        }
        Ok(())
    }
}
