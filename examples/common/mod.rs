//! What all examples share: output that may be closed early.

use std::error::Error;
use std::io::{self, StdoutLock};

/// Runs an example that writes to standard output. A reader that has seen enough, such as `head`,
/// is no error.
pub fn write(
    example: impl FnOnce(&mut StdoutLock<'static>) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    example(&mut io::stdout().lock()).or_else(|error| {
        let kind = error.downcast_ref::<io::Error>().map(io::Error::kind);
        if kind == Some(io::ErrorKind::BrokenPipe) {
            Ok(())
        } else {
            Err(error)
        }
    })
}
