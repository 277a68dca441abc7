//! What the text formats share: `#` comments, fields between blanks, numbers in full f64.

/// The statement of a line: what stands before a comment.
pub fn without_comment(line: &str) -> &str {
    line.split_once('#').map_or(line, |(statement, _)| statement)
}

/// The fields of a line, without its comment.
pub fn fields(line: &str) -> Vec<&str> {
    without_comment(line).split_ascii_whitespace().collect()
}

/// One number, to the last bit; `nan` and `inf` are numbers here.
pub fn number(field: &str) -> Result<f64, String> {
    field.parse().map_err(|_| format!("`{}` is no number", shorten(field)))
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
    field.char_indices().nth(40).map_or(field, |(end, _)| &field[..end])
}
