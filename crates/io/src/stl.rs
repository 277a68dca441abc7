//! STL, ASCII and binary, in f32 as the format defines it.
//!
//! Read here and not by a crate: the maintained one takes time in the square of the length of a line and has no line
//! numbers. Text is taken word by word, so that line ends mean nothing but after names and in unknown statements. Many
//! binary
//! files begin with `solid` like ASCII ones: the size decides, then whether there is a facet before the first zero
//! byte.
//! Equal corners become one vertex. Normals are not used, whatever they are.

use std::collections::HashMap;

use crate::notice::Notices;
use crate::text::{decode, is_utf16, shorten, without_padding};
use crate::{Place, ReadError, Surface, polygon};

const HEADER: usize = 84;
const BYTES_PER_TRIANGLE: usize = 50;

pub(crate) fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Surface, ReadError> {
    let count = bytes
        .get(HEADER - 4..HEADER)
        .map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let expected = count.map(|count| {
        BYTES_PER_TRIANGLE
            .saturating_mul(count)
            .saturating_add(HEADER)
    });
    if expected == Some(bytes.len()) {
        return Ok(parse_binary(bytes));
    }
    if is_text(bytes) {
        let text = decode(bytes);
        return parse_ascii(without_padding(&text, notices), notices);
    }
    let (Some(count), Some(expected)) = (count, expected) else {
        return Err(ReadError::new(format!(
            "neither ASCII STL nor, with {} bytes, a binary one",
            bytes.len()
        )));
    };
    let room = (bytes.len() - HEADER) / BYTES_PER_TRIANGLE;
    // Programs that write while they compute leave the number of triangles open.
    if room > 0 && (count == 0 || count == u32::MAX as usize) {
        let what =
            format!("the header leaves the number of triangles open; the file has room for {room}");
        notices.add(Place::Byte(HEADER - 4), what);
    } else if expected > bytes.len() {
        let what = format!(
            "binary STL of {count} triangles has {expected} bytes, this file has {}",
            bytes.len()
        );
        return Err(ReadError::new(what));
    }
    let end = if expected == HEADER || expected > bytes.len() {
        HEADER + BYTES_PER_TRIANGLE * room
    } else {
        expected
    };
    if end < bytes.len() {
        let what = format!(
            "{} bytes after the last triangle passed over",
            bytes.len() - end
        );
        notices.add(Place::Byte(end), what);
    }
    Ok(parse_binary(&bytes[..end]))
}

/// Whether a file is ASCII that is no binary file by its size: damaged binary files may begin with `solid` too.
fn is_text(bytes: &[u8]) -> bool {
    if is_utf16(bytes) {
        return true;
    }
    let text = bytes.split(|&byte| byte == 0).next().unwrap_or_default();
    let has = |word: &[u8]| {
        text.windows(word.len())
            .any(|window| window.eq_ignore_ascii_case(word))
    };
    has(b"facet") || has(b"endsolid")
}

/// Whether a file of unknown format is STL by its first word or its size.
pub(crate) fn is_likely(bytes: &[u8]) -> bool {
    let start = decode(&bytes[..bytes.len().min(256)])
        .trim_start()
        .to_ascii_lowercase();
    let count = bytes
        .get(HEADER - 4..HEADER)
        .map_or(0, |n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]) as usize);
    let fits = count > 0
        && BYTES_PER_TRIANGLE
            .saturating_mul(count)
            .saturating_add(HEADER)
            <= bytes.len();
    fits || ((start.starts_with("solid") || start.starts_with("facet")) && is_text(bytes))
}

/// Triangles whose equal corners are one vertex.
#[derive(Default)]
struct Corners {
    surface: Surface,
    vertices: HashMap<[u32; 3], u32>,
}

impl Corners {
    fn vertex(&mut self, corner: [f32; 3], place: Place) -> u32 {
        *self
            .vertices
            .entry(corner.map(f32::to_bits))
            .or_insert_with(|| {
                self.surface.vertices.push(corner.map(f64::from));
                self.surface.places.push(place);
                (self.surface.vertices.len() - 1) as u32
            })
    }
}

fn parse_binary(bytes: &[u8]) -> Surface {
    let mut corners = Corners::default();
    for (start, triangle) in (HEADER..)
        .step_by(BYTES_PER_TRIANGLE)
        .zip(bytes[HEADER..].chunks_exact(BYTES_PER_TRIANGLE))
    {
        let number = |at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| triangle[at + i]));
        // After the normal.
        let vertices = [12, 24, 36].map(|at| {
            (
                [0, 4, 8].map(|axis| number(at + axis)),
                Place::Byte(start + at),
            )
        });
        let triangle = vertices.map(|(corner, place)| corners.vertex(corner, place));
        corners.surface.triangles.push(triangle);
    }
    corners.surface
}

fn parse_ascii(text: &str, notices: &mut Notices) -> Result<Surface, ReadError> {
    let mut words = Words {
        rest: text.as_bytes(),
        line: 1,
    };
    let mut corners = Corners::default();
    let mut is_open = false;
    while let Some(word) = words.clone().next() {
        if words.is_next("solid") {
            words.next();
            words.skip_name(|words| words.is_next("endsolid") || words.is_facet());
            is_open = true;
        } else if words.is_next("endsolid") {
            words.next();
            words.skip_name(Words::is_solid_on_line);
            is_open = false;
        } else if words.is_next("facet") {
            facet(&mut words, &mut corners, notices)?;
        } else if is_keyword(word) {
            return words.expect("facet").map(|()| Surface::default());
        } else {
            words.skip_unknown(notices);
        }
    }
    if is_open {
        notices.add(Place::Line(words.line), "the file ends without `endsolid`");
    }
    Ok(corners.surface)
}

fn facet(
    words: &mut Words<'_>,
    corners: &mut Corners,
    notices: &mut Notices,
) -> Result<(), ReadError> {
    words.expect("facet")?;
    let first = words.line;
    words.expect("normal")?;
    // The normal, which some programs leave out.
    for _ in 0..3 {
        if words.clone().next().is_some_and(|word| !is_keyword(word)) {
            words.next();
        }
    }
    words.statement("outer", notices)?;
    words.expect("loop")?;
    let mut outline = Vec::with_capacity(3);
    while !words.is_at("endloop", notices) {
        words.expect("vertex")?;
        let place = Place::Line(words.line);
        let corner = [words.number()?, words.number()?, words.number()?];
        outline.push(corners.vertex(corner, place));
    }
    words.expect("endloop")?;
    words.statement("endfacet", notices)?;
    let Surface {
        vertices,
        triangles,
        ..
    } = &mut corners.surface;
    let oddity = polygon::fill(&outline, vertices, triangles);
    if let Some(oddity) =
        oddity.or((outline.len() > 3).then_some("facet of more than 3 corners filled as a polygon"))
    {
        notices.add(Place::Line(first), oddity);
    }
    Ok(())
}

/// Words by which a statement begins.
const KEYWORDS: [&str; 7] = [
    "solid", "endsolid", "facet", "endfacet", "outer", "endloop", "vertex",
];

fn is_keyword(word: &[u8]) -> bool {
    KEYWORDS
        .iter()
        .any(|keyword| word.eq_ignore_ascii_case(keyword.as_bytes()))
}

/// The words of a text, and the line of the last one.
#[derive(Clone)]
struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let blanks = self
            .rest
            .iter()
            .position(|byte| !byte.is_ascii_whitespace())?;
        self.line += line_ends(&self.rest[..blanks]);
        self.rest = &self.rest[blanks..];
        let end = self
            .rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Some(word)
    }

    fn is_next(&self, word: &str) -> bool {
        self.clone()
            .next()
            .is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()))
    }

    /// Whether a facet begins here: `facet normal`, three words, `outer`. A name may have the first two.
    fn is_facet(&self) -> bool {
        let mut words = self.clone();
        let mut is_next = |word: &str| {
            words
                .next()
                .is_some_and(|next| next.eq_ignore_ascii_case(word.as_bytes()))
        };
        is_next("facet") && is_next("normal") && words.nth_is(3, "outer")
    }

    /// Whether a word follows after so many others.
    fn nth_is(mut self, n: usize, word: &str) -> bool {
        (0..n).all(|_| self.next().is_some()) && self.is_next(word)
    }

    /// Passes over unknown statements before a word, and tells whether it is next.
    fn is_at(&mut self, word: &str, notices: &mut Notices) -> bool {
        while self.clone().next().is_some_and(|next| !is_keyword(next)) {
            self.skip_unknown(notices);
        }
        self.is_next(word)
    }

    /// A word that may have unknown statements before it.
    fn statement(&mut self, word: &str, notices: &mut Notices) -> Result<(), ReadError> {
        self.is_at(word, notices);
        self.expect(word)
    }

    /// Passes over the rest of a line, up to a keyword.
    fn skip_unknown(&mut self, notices: &mut Notices) {
        let Some(word) = self.next() else { return };
        let what = format!(
            "unknown statement `{}` passed over",
            shorten(&String::from_utf8_lossy(word))
        );
        notices.add(Place::Line(self.line), what);
        self.skip_name(|words| words.clone().next().is_some_and(is_keyword));
    }

    /// Whether a solid begins here with a facet on the same line; its name may have a few words.
    fn is_solid_on_line(&self) -> bool {
        let mut words = self.clone();
        let mut is_facet_next =
            || words.next().is_some() && words.line == self.line && words.is_facet();
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
            Some(next) => Err(self.fault(&format!(
                "expected `{word}`, found `{}`",
                shorten(&String::from_utf8_lossy(next))
            ))),
            None => Err(self.fault(&format!("expected `{word}`, found the end of the file"))),
        }
    }

    fn number(&mut self) -> Result<f32, ReadError> {
        let word = String::from_utf8_lossy(self.next().unwrap_or_default());
        word.parse()
            .map_err(|_| self.fault(&format!("`{}` is no number", shorten(&word))))
    }

    fn fault(&self, what: &str) -> ReadError {
        ReadError::at_line(self.line, what)
    }
}

/// Line feeds, carriage returns, or both together.
fn line_ends(blanks: &[u8]) -> usize {
    let mut before = 0;
    let ends = |&byte: &u8| {
        let is_end = byte == b'\r' || (byte == b'\n' && before != b'\r');
        before = byte;
        is_end
    };
    blanks.iter().copied().filter(ends).count()
}
