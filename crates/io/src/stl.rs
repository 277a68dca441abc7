//! STL, ASCII and binary, in f32 as the format defines it.
//!
//! Read here and not by a crate: the maintained one takes time in the square of the length of a line and has no line
//! numbers. Text is taken word by word, so that line ends mean nothing but after names. Many binary files begin with `solid`
//! like ASCII ones: the size decides. Equal corners become one vertex. Normals are not used, whatever they are.

use std::collections::HashMap;

use crate::text::shorten;
use crate::{Place, ReadError, Surface};

const HEADER: usize = 84;
const BYTES_PER_TRIANGLE: usize = 50;

pub(crate) fn parse(bytes: &[u8]) -> Result<Surface, ReadError> {
    let count = bytes.get(HEADER - 4..HEADER).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let expected = count.map(|count| HEADER + BYTES_PER_TRIANGLE * count);
    if expected == Some(bytes.len()) {
        return parse_binary(bytes);
    }
    // A damaged binary file may begin with `solid` too; but no text has zeros.
    let start = bytes.trim_ascii_start().get(..5).unwrap_or_default();
    if start.eq_ignore_ascii_case(b"solid") && !bytes.contains(&0) {
        return parse_ascii(bytes);
    }
    Err(ReadError::new(match (count, expected) {
        (Some(count), Some(expected)) => {
            format!("binary STL of {count} triangles has {expected} bytes, this file has {}", bytes.len())
        }
        _ => format!("neither ASCII STL nor, with {} bytes, a binary one", bytes.len()),
    }))
}

/// Triangles whose equal corners are one vertex.
#[derive(Default)]
struct Corners {
    surface: Surface,
    vertices: HashMap<[u32; 3], u32>,
}

impl Corners {
    fn vertex(&mut self, corner: [f32; 3], place: Place) -> u32 {
        *self.vertices.entry(corner.map(f32::to_bits)).or_insert_with(|| {
            self.surface.vertices.push(corner.map(f64::from));
            self.surface.places.push(place);
            (self.surface.vertices.len() - 1) as u32
        })
    }
}

fn parse_binary(bytes: &[u8]) -> Result<Surface, ReadError> {
    let mut corners = Corners::default();
    for (start, triangle) in
        (HEADER..).step_by(BYTES_PER_TRIANGLE).zip(bytes[HEADER..].chunks_exact(BYTES_PER_TRIANGLE))
    {
        let number = |at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| triangle[at + i]));
        // After the normal.
        let vertices = [12, 24, 36].map(|at| ([0, 4, 8].map(|axis| number(at + axis)), Place::Byte(start + at)));
        let triangle = vertices.map(|(corner, place)| corners.vertex(corner, place));
        corners.surface.triangles.push(triangle);
    }
    Ok(corners.surface)
}

fn parse_ascii(text: &[u8]) -> Result<Surface, ReadError> {
    let mut words = Words { rest: text, line: 1 };
    let mut corners = Corners::default();
    while words.peek().is_some() {
        words.expect("solid")?;
        words.skip_name(|words| words.is_next("endsolid") || words.is_facet());
        while !words.is_next("endsolid") {
            let triangle = facet(&mut words, &mut corners)?;
            corners.surface.triangles.push(triangle);
        }
        words.expect("endsolid")?;
        words.skip_name(Words::is_solid_on_line);
    }
    Ok(corners.surface)
}

fn facet(words: &mut Words<'_>, corners: &mut Corners) -> Result<[u32; 3], ReadError> {
    words.expect("facet")?;
    words.expect("normal")?;
    for _ in 0..3 {
        words.next();
    }
    words.expect("outer")?;
    words.expect("loop")?;
    let mut triangle = [0; 3];
    for corner in &mut triangle {
        words.expect("vertex")?;
        let place = Place::Line(words.line);
        let coordinates = [words.number()?, words.number()?, words.number()?];
        *corner = corners.vertex(coordinates, place);
    }
    words.expect("endloop")?;
    words.expect("endfacet")?;
    Ok(triangle)
}

/// The words of a text, and the line of the last one.
#[derive(Clone)]
struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let blanks = self.rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        self.line += self.rest[..blanks].iter().filter(|&&byte| byte == b'\n').count();
        self.rest = &self.rest[blanks..];
        let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some(word)
    }

    fn peek(&self) -> Option<&'a [u8]> {
        self.clone().next()
    }

    fn is_next(&self, word: &str) -> bool {
        self.peek().is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()))
    }

    /// Whether a facet begins here.
    fn is_facet(&self) -> bool {
        let mut words = self.clone();
        let mut is_next = |word: &str| words.next().is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()));
        is_next("facet") && is_next("normal")
    }

    /// Whether a solid begins here with a facet on the same line; its name may have a few words.
    fn is_solid_on_line(&self) -> bool {
        let mut words = self.clone();
        let mut is_facet_next = || words.next().is_some() && words.line == self.line && words.is_facet();
        self.is_next("solid") && (0..8).any(|_| is_facet_next())
    }

    /// Skips a name: the words up to the end of the line, or up to `end` where all is on one line.
    fn skip_name(&mut self, end: impl Fn(&Self) -> bool) {
        loop {
            let mut after = self.clone();
            if after.next().is_none() || after.line > self.line || end(self) {
                return;
            }
            *self = after;
        }
    }

    fn expect(&mut self, word: &str) -> Result<(), ReadError> {
        match self.next() {
            Some(next) if next.eq_ignore_ascii_case(word.as_bytes()) => Ok(()),
            Some(next) => {
                Err(self.fault(&format!("expected `{word}`, found `{}`", shorten(&String::from_utf8_lossy(next)))))
            }
            None => Err(self.fault(&format!("expected `{word}`, found the end of the file"))),
        }
    }

    fn number(&mut self) -> Result<f32, ReadError> {
        let word = String::from_utf8_lossy(self.next().unwrap_or_default());
        word.parse().map_err(|_| self.fault(&format!("`{}` is no number", shorten(&word))))
    }

    fn fault(&self, what: &str) -> ReadError {
        ReadError::at_line(self.line, what)
    }
}
