//! The file of `--calibration`: what was learned of a pair of parts, from one run of the program to the next.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process;

use punctual::prediction::Calibration;
use punctual_io::FileError;

/// A calibration and the file that it is kept in.
pub struct CalibrationFile {
    path: PathBuf,
    pub calibration: Calibration,
}

impl CalibrationFile {
    /// Reads the file; one that does not exist yet has learned nothing.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let calibration = match fs::read(path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| damage(path, &error))?,
            Err(error) if error.kind() == ErrorKind::NotFound => Calibration::default(),
            Err(error) => return Err(FileError::from_io(path, &error)),
        };
        Ok(Self {
            path: path.to_owned(),
            calibration,
        })
    }

    /// Writes a file beside it and then renames that, so that there is a whole one at any time.
    pub fn write(&self) -> Result<(), FileError> {
        let mut name = self.path.clone().into_os_string();
        name.push(format!(".{}.tmp", process::id()));
        let beside = PathBuf::from(name);
        let json =
            serde_json::to_string(&self.calibration).map_err(|error| damage(&self.path, &error))?;
        let written =
            fs::write(&beside, json + "\n").and_then(|()| fs::rename(&beside, &self.path));
        written.map_err(|error| {
            let _ = fs::remove_file(&beside);
            FileError::from_io(&self.path, &error)
        })
    }
}

/// What is wrong with the file, and where; a value that is out of range is named without its place.
fn damage(path: &Path, error: &serde_json::Error) -> FileError {
    let text = error.to_string();
    let what = text.split(" at line ").next().unwrap_or_default();
    match error.line() {
        0 => FileError::from_io(path, &io::Error::other(what)),
        line => FileError::at_line(path, line, format!("column {}: {what}", error.column())),
    }
}
