//! Text: a point a line.

use crate::notice::Notices;
use crate::text::{decode, lines, number, without_comment, without_padding};
use crate::{Place, ReadError};

pub fn parse(bytes: &[u8], notices: &mut Notices) -> Result<Vec<[f64; 3]>, ReadError> {
    let text = decode(bytes);
    let text = without_padding(&text, notices);
    let mut points = Vec::new();
    let mut may_be_heading = true;
    for (line, at) in lines(text).zip(1..) {
        let line = without_comment(line);
        let line = line.split_once("//").map_or(line, |(before, _)| before);
        let is_blank = |c: char| c.is_ascii_whitespace() || matches!(c, ',' | ';');
        let mut fields = line.split(is_blank).filter(|field| !field.is_empty());
        let Some(first) = fields.next() else {
            continue;
        };
        let mut coordinate = |count: usize| match fields.next() {
            Some(field) => number(field),
            None => Err(format!("point of {count} coordinates, must be 3")),
        };
        let point = number(first).and_then(|x| Ok([x, coordinate(1)?, coordinate(2)?]));
        match point {
            Ok(point) => points.push(point),
            Err(_) if may_be_heading => notices.add(Place::Line(at), "a heading passed over"),
            Err(what) => return Err(ReadError::at_line(at, what)),
        }
        may_be_heading = false;
    }
    Ok(points)
}
