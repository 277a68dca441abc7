//! What is promised, tested at every stop of the sweep.

use crate::report::{Section, Verdict};

use super::super::measure::Asked;
use super::super::summary::{Measurement, overruns};
use super::Report;

impl Report<'_> {
    pub(super) fn guarantees(&self) -> [Section; 3] {
        let sum =
            |count: &dyn Fn(&Measurement) -> usize| self.cases.iter().map(count).sum::<usize>();
        let wrong = sum(&|case| {
            case.work.wrong.len() + case.rounds.iter().map(|round| round.wrong).sum::<usize>()
        });
        let stops = sum(&|case| {
            let rounds = case.rounds.iter().flat_map(|round| &round.rows);
            let rows = case.work.rows.iter().chain(rounds);
            let rows = rows.filter(|row| row.asked != Asked::Distance);
            case.work.distances + rows.count()
        });
        let certificates = sum(&|case| case.work.certificates);
        let loose = sum(&|case| case.work.loose.len());
        let [(overrun, most), (of_distances, most_of_distances)] = overruns(self.cases);
        let tested = |id, title, claim: &str, holds: bool, measured: String| {
            Section::claims(id, title, (claim, Verdict::from(holds)), measured, vec![])
        };
        [
            tested(
                "wrong",
                "Wrong answers",
                "Whenever a query is stopped, what it says is true: no wrong yes or no, no pair of triangles that does not \
                 meet, none twice, no distance outside of its bounds. A finished query has found all pairs.",
                wrong == 0,
                format!("{wrong} wrong in {stops} stops."),
            ),
            tested(
                "bounds",
                "What may have been missed",
                "A stopped query bounds what it may have missed: its bound on the number of pairs is never too low, and each \
                 missed pair meets in one of the boxes that it names.",
                loose == 0,
                format!(
                    "{loose} false in {certificates} certificates (one missed pair was looked up in each)."
                ),
            ),
            tested(
                "overrun",
                "Budgets of work",
                &format!(
                    "A budget of work is overrun by one step at most, {most} units, or {most_of_distances} of a distance query."
                ),
                overrun <= most && of_distances <= most_of_distances,
                format!("By {overrun} units at most, and {of_distances} of distance queries."),
            ),
        ]
    }
}
