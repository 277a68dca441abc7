//! The constants of the engine's model from queries of known truth, and how well they do.
//!
//! Each query is run to its end, and stopped at 2, 5, 10, 20 and 50 % of the work of the complete query; what the model sees
//! at each moment is set against what came of it. All but intersections are stopped at these shares of their own work.

mod cases;
mod evaluate;
mod moments;
mod plots;
mod sample;
mod source;

pub use cases::Case;
pub use evaluate::report;
pub use source::fit;

use moments::Moments;
use punctual::internals::Lead;
use sample::Sample;

/// Queries that are fitted to, or reported on.
#[derive(Default)]
pub struct Data {
    names: Vec<String>,
    poses: usize,
    samples: Vec<Sample>,
    moments: Moments,
}

/// What is asked at the poses of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// All questions.
    Everything,
    /// Only intersections, but not the recall of queries that follow curves.
    Intersections,
    /// All but intersections.
    Others,
}

impl Data {
    /// Runs the queries of a case and keeps what was seen at each moment.
    pub fn add(&mut self, case: &Case, asked: Asked) {
        let number = self.names.len();
        self.names.push(case.name.clone());
        self.poses += case.poses.len();
        if asked != Asked::Others {
            // Poses near the first touch would outweigh the others in the recall along curves.
            let samples = sample::samples(number, case).into_iter();
            self.samples.extend(
                samples.filter(|sample| asked == Asked::Everything || sample.lead == Lead::Nothing),
            );
        }
        if asked != Asked::Intersections {
            self.moments.add(number, case);
        }
    }

    /// The numbers of cases, of poses, and of moments of queries.
    pub fn counts(&self) -> [usize; 3] {
        let moments = self.samples.len() + self.moments.count();
        [self.names.len(), self.poses, moments]
    }
}
