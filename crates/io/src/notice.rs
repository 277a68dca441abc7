//! What a reader passed over, or read in a way of its own.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;

use crate::Place;
use crate::error::{Printable, short};

/// Something in a file that was passed over, or read although it is out of order: what, where first, and how often.
///
/// Its text is one line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Notice {
    /// What was passed over, or how it was read.
    pub what: String,
    /// The first place, if it has one.
    pub place: Option<Place>,
    /// The number of places.
    pub count: usize,
}

impl Notice {
    /// The text with the name of the file, like that of a [`FileError`](crate::FileError).
    pub fn in_file(&self, file: &Path) -> String {
        match self.place {
            Some(Place::Line(line)) => format!("{}:{line}: {}", file.display(), self.text()),
            _ => format!("{}: {self}", file.display()),
        }
    }

    fn text(&self) -> String {
        let often = if self.count > 1 {
            format!(" ({} times)", self.count)
        } else {
            String::new()
        };
        format!("{}{often}", Printable(&self.what))
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = self.place {
            write!(f, "{place}: ")?;
        }
        f.write_str(&self.text())
    }
}

/// Most notices of one file. Damaged files have unknown statements of any number.
const MOST: usize = 16;

/// Gathers notices; equal ones are counted.
#[derive(Default)]
pub(crate) struct Notices(Vec<Notice>);

impl Notices {
    pub fn add(&mut self, place: impl Into<Option<Place>>, what: impl Into<Cow<'static, str>>) {
        let mut what = what.into();
        if self.0.len() >= MOST && self.0.iter().all(|notice| notice.what != what) {
            what = "other things passed over".into();
        }
        match self.0.iter_mut().find(|notice| notice.what == what) {
            Some(notice) => notice.count += 1,
            None => self.0.push(Notice {
                what: short(what.into_owned()),
                place: place.into(),
                count: 1,
            }),
        }
    }

    /// By place; those without one are last.
    pub fn into_list(mut self) -> Vec<Notice> {
        self.0.sort_by_key(|notice| match notice.place {
            Some(Place::Line(at) | Place::Byte(at)) => at,
            None => usize::MAX,
        });
        self.0
    }

    /// The first, for an error where nothing else was found.
    pub fn first(&self) -> Option<&Notice> {
        self.0.first()
    }
}
