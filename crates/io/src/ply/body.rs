//! The body of a PLY file: one number after the other, from text or from bytes.

use super::header::{Element, Encoding, Header, Kind, Property};
use crate::notice::Notices;
use crate::text::shorten;
use crate::{Place, ReadError};

pub struct Body<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
    /// The byte that ends a line of text.
    line_end: u8,
    /// Where the next number is; in text, where the next line begins.
    at: usize,
    /// The element being read: its line, and what is left of it; or the byte where it begins.
    place: Place,
    words: &'a [u8],
}

impl<'a> Body<'a> {
    pub fn new(bytes: &'a [u8], header: &Header) -> Self {
        let place = match header.encoding {
            Encoding::Ascii => Place::Line(header.lines),
            _ => Place::Byte(header.end),
        };
        let (encoding, line_end) = (header.encoding, header.line_end);
        Self {
            bytes,
            encoding,
            line_end,
            at: header.end,
            place,
            words: b"",
        }
    }

    /// Goes to the next element, and says where it is.
    pub fn begin(&mut self, element: &Element) -> Result<Place, ReadError> {
        let Place::Line(line) = &mut self.place else {
            self.place = Place::Byte(self.at);
            return Ok(self.place);
        };
        self.words = b"";
        while self.words.is_empty() {
            let rest = &self.bytes[self.at..];
            if rest.is_empty() {
                return Err(self.fault(format!(
                    "end of file before the last `{}`",
                    shorten(&element.name)
                )));
            }
            let end = rest
                .iter()
                .position(|&byte| byte == self.line_end)
                .map_or(rest.len(), |end| end + 1);
            *line += 1;
            self.at += end;
            self.words = rest[..end].trim_ascii();
        }
        Ok(self.place)
    }

    /// Ends an element.
    pub fn end(&self, notices: &mut Notices) {
        if !self.words.is_empty() {
            notices.add(
                self.place,
                "more values than properties; the last are passed over",
            );
        }
    }

    /// Ends the file.
    pub fn finish(&self, notices: &mut Notices) {
        let rest = &self.bytes[self.at..];
        let is_text = self.encoding == Encoding::Ascii;
        let is_blank = if is_text {
            rest.trim_ascii().is_empty()
        } else {
            rest.is_empty()
        };
        if !is_blank {
            let what = format!(
                "{} bytes after what the header announces passed over",
                rest.len()
            );
            notices.add((!is_text).then_some(Place::Byte(self.at)), what);
        }
    }

    pub fn number(&mut self, kind: Kind) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            let number = match kind {
                Kind::F64 => word.parse().ok(),
                Kind::F32 => word.parse::<f32>().ok().map(f64::from),
                _ => word.parse::<i64>().ok().map(|number| number as f64),
            };
            return number.ok_or_else(|| {
                let is_float = matches!(kind, Kind::F32 | Kind::F64);
                self.fault(format!(
                    "`{}` is no {}",
                    shorten(&word),
                    if is_float { "number" } else { "whole number" }
                ))
            });
        }
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.take()?).into(),
            Kind::U8 => u8::from_le_bytes(self.take()?).into(),
            Kind::I16 => i16::from_le_bytes(self.take()?).into(),
            Kind::U16 => u16::from_le_bytes(self.take()?).into(),
            Kind::I32 => i32::from_le_bytes(self.take()?).into(),
            Kind::U32 => u32::from_le_bytes(self.take()?).into(),
            Kind::F32 => f32::from_le_bytes(self.take()?).into(),
            Kind::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    /// How many values of a list follow.
    pub fn count(&mut self, kind: Kind) -> Result<u64, ReadError> {
        let count = self.number(kind)?;
        if count < 0.0 {
            Err(self.fault(format!("a list of {count} values")))
        } else {
            Ok(count as u64)
        }
    }

    pub fn skip(&mut self, property: &Property) -> Result<(), ReadError> {
        let count = property.count.map_or(Ok(1), |count| self.count(count))?;
        (0..count).try_for_each(|_| match self.encoding {
            Encoding::Ascii => self.word().map(drop),
            _ => self.number(property.kind).map(drop),
        })
    }

    fn word(&mut self) -> Result<std::borrow::Cow<'a, str>, ReadError> {
        if self.words.is_empty() {
            return Err(self.fault("fewer values than properties"));
        }
        let end = self
            .words
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(self.words.len());
        let (word, rest) = self.words.split_at(end);
        self.words = rest.trim_ascii_start();
        Ok(String::from_utf8_lossy(word))
    }

    /// The bytes of the next number, the lowest first.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let mut bytes = *self.bytes[self.at..]
            .first_chunk()
            .ok_or_else(|| self.fault("end of file within an element"))?;
        self.at += N;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn fault(&self, what: impl Into<String>) -> ReadError {
        ReadError::at(self.place, what)
    }
}
