//! What the text formats share: encodings, lines, `#` comments, fields between blanks, numbers in full f64.

use std::borrow::Cow;

use crate::notice::Notices;

/// The text of a file: UTF-8 with or without a byte order mark, or UTF-16 with one. Bytes that are no text become
/// U+FFFD.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |number: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..]
            .chunks_exact(2)
            .map(|pair| number([pair[0], pair[1]]))
            .collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)),
    }
}

/// An XML text without its declaration, if that does not come first, as XML wants it, but behind blanks or comments.
/// Lines keep their numbers.
pub fn without_late_declaration(text: &str) -> Cow<'_, str> {
    let late = text.find("<?xml").filter(|&start| start > 0);
    let is_declaration = |rest: &str| rest.starts_with(|c: char| c.is_ascii_whitespace());
    let Some(start) = late.filter(|&start| is_declaration(&text[start + 5..])) else {
        return Cow::Borrowed(text);
    };
    let (before, rest) = text.split_at(start);
    let Some((declaration, after)) = rest.split_once("?>") else {
        return Cow::Borrowed(text);
    };
    let lines = declaration.matches('\n');
    Cow::Owned([before].into_iter().chain(lines).chain([after]).collect())
}

/// Whether a byte order mark says that a text is UTF-16.
pub(crate) fn is_utf16(bytes: &[u8]) -> bool {
    matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..])
}

/// The lines of a text, which end with a line feed, a carriage return, or both.
pub fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = rest
            .bytes()
            .position(|byte| byte == b'\n' || byte == b'\r')
            .unwrap_or(rest.len());
        let (line, after) = rest.split_at(end);
        let end = if after.starts_with("\r\n") {
            2
        } else {
            after.len().min(1)
        };
        rest = &after[end..];
        Some(line)
    })
}

/// A text without the zeros and end marks (Ctrl-Z) that old programs fill its last block with.
pub(crate) fn without_padding<'t>(text: &'t str, notices: &mut Notices) -> &'t str {
    let is_padding = |c: char| matches!(c, '\0' | '\u{1a}');
    let cut = text.trim_end_matches(|c: char| is_padding(c) || c.is_ascii_whitespace());
    let padding = text[cut.len()..].chars().filter(|&c| is_padding(c)).count();
    if padding > 0 {
        notices.add(
            None,
            format!("{padding} bytes of padding after the text passed over"),
        );
        return cut;
    }
    text
}

/// The statement of a line: what stands before a comment.
pub fn without_comment(line: &str) -> &str {
    line.split_once('#')
        .map_or(line, |(statement, _)| statement)
}

/// The fields of a line, without its comment.
pub fn fields(line: &str) -> Vec<&str> {
    without_comment(line).split_ascii_whitespace().collect()
}

/// One number, to the last bit; `nan` and `inf` are numbers here.
pub fn number(field: &str) -> Result<f64, String> {
    field
        .parse()
        .map_err(|_| format!("`{}` is no number", shorten(field)))
}

/// Exactly `N` numbers.
pub fn numbers<const N: usize>(fields: &[&str]) -> Result<[f64; N], String> {
    if fields.len() != N {
        return Err(format!("{} numbers, must be {N}", fields.len()));
    }
    let mut numbers = [0.0; N];
    for (slot, field) in numbers.iter_mut().zip(fields) {
        *slot = number(field)?;
    }
    Ok(numbers)
}

/// The beginning of a field, for messages: damaged files have fields of any length.
pub fn shorten(field: &str) -> &str {
    field
        .char_indices()
        .nth(40)
        .map_or(field, |(end, _)| &field[..end])
}
