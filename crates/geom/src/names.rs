//! Names of enums: `named!` makes `Display` and `FromStr` from one table. The program and its
//! files use these names.

use alloc::borrow::ToOwned;
use alloc::string::String;
use core::fmt;

/// A text that names no variant of an enum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    given: String,
    known: &'static [&'static str],
}

impl UnknownName {
    /// The error for this text, with the names that there are.
    pub fn new(given: &str, known: &'static [&'static str]) -> Self {
        Self {
            given: given.to_owned(),
            known,
        }
    }
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} is none of {}", self.given, self.known.join(", "))
    }
}

impl core::error::Error for UnknownName {}

/// Implements `Display` and `FromStr` for an enum without fields.
#[macro_export]
macro_rules! named {
    ($type:ident { $($variant:ident => $name:literal),+ $(,)? }) => {
        impl core::fmt::Display for $type {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(match self { $(Self::$variant => $name),+ })
            }
        }

        impl core::str::FromStr for $type {
            type Err = $crate::UnknownName;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                match name {
                    $($name => Ok(Self::$variant),)+
                    _ => Err($crate::UnknownName::new(name, &[$($name),+])),
                }
            }
        }
    };
}
