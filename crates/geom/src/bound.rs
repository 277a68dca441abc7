//! Serializes an `f64` that may be infinite: infinity becomes `None`, because some formats cannot
//! represent it.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes a bound.
pub fn serialize<S: Serializer>(bound: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Some(*bound)
        .filter(|bound| bound.is_finite())
        .serialize(serializer)
}

/// Reads a bound.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}
