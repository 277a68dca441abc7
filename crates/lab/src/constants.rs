//! The constants of the engine's model from queries of known truth, and how well they do.
//!
//! Each query is run to its end, and stopped at 2, 5, 10, 20 and 50 % of the work of the complete query; what the model sees
//! at each moment is set against what came of it. Queries of distances and motions are stopped at these shares of their own work.

mod batches;
mod cases;
mod distances;
mod evaluate;
mod listings;
mod motions;
mod plots;
mod sample;
mod source;

pub use cases::Case;
pub use evaluate::report;
pub use source::fit;

use distances::Moment;
use punctual::internals::Lead;
use sample::Sample;

/// Queries that are fitted to, or reported on.
#[derive(Default)]
pub struct Data {
    names: Vec<String>,
    poses: usize,
    samples: Vec<Sample>,
    moments: Vec<Moment>,
    motions: Vec<motions::Moment>,
    listings: Vec<listings::Moment>,
    batches: Vec<batches::Moment>,
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
        if asked == Asked::Intersections {
            // Poses near the first touch would outweigh the others in the recall along curves.
            let samples = sample::samples(number, case).into_iter();
            self.samples
                .extend(samples.filter(|sample| sample.lead == Lead::Nothing));
            return;
        }
        if asked == Asked::Everything {
            self.samples.extend(sample::samples(number, case));
        }
        self.moments.extend(distances::moments(number, case));
        self.motions.extend(motions::moments(number, case));
        self.listings.extend(listings::moments(number, case));
        self.batches.extend(batches::moments(number, case));
    }

    /// The numbers of cases, of poses, and of moments of queries.
    pub fn counts(&self) -> [usize; 3] {
        [
            self.names.len(),
            self.poses,
            self.samples.len()
                + self.moments.len()
                + self.motions.len()
                + self.listings.len()
                + self.batches.len(),
        ]
    }
}
