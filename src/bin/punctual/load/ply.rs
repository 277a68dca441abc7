//! PLY, ASCII and binary of both byte orders, by `ply-rs-bw`. Coordinates may be of any number type; `double` is kept.

use std::io::{BufRead, Cursor};

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use super::{Fault, Surface};

const AXES: [&str; 3] = ["x", "y", "z"];
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

type Source<'a> = Reader<Cursor<&'a [u8]>>;

pub fn parse(bytes: &[u8]) -> Result<Surface, Fault> {
    let mut source = Reader::new(Cursor::new(bytes));
    let header = Parser::<Skipped>::new().read_header(&mut source);
    let header = header.map_err(|error| fault(&error, Some(source.line())))?;
    check_header(&header, bytes.len())?;
    let mut surface = Surface::default();
    let mut faces = (Vec::new(), 0);
    for element in header.elements.values() {
        let first_line = source.line();
        match element.name.as_str() {
            "vertex" => {
                let vertices: Vec<Vertex> = payload(&mut source, element, &header)?;
                surface.vertices = vertices.iter().map(|vertex| vertex.0).collect();
                if is_text(&header) {
                    surface.vertex_lines = (first_line..first_line + vertices.len()).collect();
                }
            }
            "face" => faces = (payload::<Face>(&mut source, element, &header)?, first_line),
            _ => drop(payload::<Skipped>(&mut source, element, &header)?),
        }
    }
    check_end(&mut source, &header)?;
    let (faces, first_line) = faces;
    for (i, Face(corners)) in faces.iter().enumerate() {
        match check_face(corners.as_deref(), surface.vertices.len()) {
            Ok(corners) => surface.push_polygon(corners),
            Err(what) if is_text(&header) => return Err(Fault::at(first_line + i, what)),
            Err(what) => return Err(Fault::new(format!("face {i} (counted from 0): {what}"))),
        }
    }
    Ok(surface)
}

/// What the parser would trust: that counts are not absurd and that the properties we need are there.
fn check_header(header: &Header, bytes: usize) -> Result<(), Fault> {
    let is_scalar = |element: &ElementDef, name| {
        element.properties.get(name).is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
    };
    for required in ["vertex", "face"] {
        if !header.elements.contains_key(required) {
            return Err(Fault::new(format!("the file has no element `{required}`")));
        }
    }
    for element in header.elements.values() {
        let name = element.name.as_str();
        if element.count > bytes {
            let what = format!("{} elements `{name}` do not fit into {bytes} bytes", element.count);
            return Err(Fault::new(what));
        }
        if name == "vertex" && !AXES.iter().all(|&axis| is_scalar(element, axis)) {
            return Err(Fault::new("element `vertex` must have the properties x, y and z"));
        }
        if name == "face" && !CORNER_LISTS.iter().any(|&list| element.properties.contains_key(list)) {
            return Err(Fault::new("element `face` must have a list `vertex_indices`"));
        }
    }
    Ok(())
}

fn payload<E: PropertyAccess>(source: &mut Source<'_>, element: &ElementDef, header: &Header) -> Result<Vec<E>, Fault> {
    let elements = Parser::<E>::new().read_payload_for_element(source, element, header);
    elements.map_err(|error| fault(&error, is_text(header).then(|| source.line())))
}

fn check_end(source: &mut Source<'_>, header: &Header) -> Result<(), Fault> {
    let line = source.line();
    let rest = source.get_mut().fill_buf().unwrap_or_default();
    match is_text(header) {
        true if !rest.trim_ascii().is_empty() => Err(Fault::at(line, "more lines than the header announces")),
        false if !rest.is_empty() => Err(Fault::new(format!("{} bytes more than the header announces", rest.len()))),
        _ => Ok(()),
    }
}

fn check_face(corners: Option<&[u32]>, vertices: usize) -> Result<&[u32], String> {
    let corners = corners.ok_or("vertex indices must be integers of 0 or more")?;
    if corners.len() < 3 {
        return Err(format!("face of {} corners, must be 3 or more", corners.len()));
    }
    match corners.iter().find(|&&corner| corner as usize >= vertices) {
        Some(corner) => Err(format!("vertex index {corner} is out of range: {vertices} vertices, counted from 0")),
        None => Ok(corners),
    }
}

fn is_text(header: &Header) -> bool {
    header.encoding == Encoding::Ascii
}

/// The parser's message on one line, without its inner state. Its line number is one in text only.
fn fault(error: &ParseError, text_line: Option<usize>) -> Fault {
    let message = error.to_string();
    let prefix = error.line().map(|line| format!("Line {line}: "));
    let what = message.strip_prefix(&prefix.unwrap_or_default()).unwrap_or(&message);
    let what = what.split("Error: ParseError").next().unwrap_or_default();
    let words: Vec<&str> = what.split_whitespace().collect();
    Fault {
        line: text_line.map(|line| error.line().unwrap_or(line)),
        what: words.join(" ").chars().take(200).collect(),
    }
}

struct Vertex([f64; 3]);
struct Face(Option<Vec<u32>>);
struct Skipped;

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f64::NAN; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = AXES.iter().position(|&axis| axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[axis] = match property {
            Property::Char(c) => c.into(),
            Property::UChar(c) => c.into(),
            Property::Short(c) => c.into(),
            Property::UShort(c) => c.into(),
            Property::Int(c) => c.into(),
            Property::UInt(c) => c.into(),
            Property::Float(c) => c.into(),
            Property::Double(c) => c,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(None)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !CORNER_LISTS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = property.to_u32_list();
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
