//! What is promised, tested at every stop of the sweep.

use crate::report::{Lead, Section, Verdict};

use super::super::summary::{Measurement, overruns};
use super::Report;

impl Report<'_> {
    pub(super) fn guarantees(&self) -> Vec<Section> {
        let sum =
            |count: &dyn Fn(&Measurement) -> usize| self.cases.iter().map(count).sum::<usize>();
        let wrong = sum(&|case| {
            case.work.wrong.len()
                + case.distance.wrong.len()
                + case.rounds.iter().map(|round| round.wrong).sum::<usize>()
        });
        let stops = sum(&|case| {
            case.work.rows.len()
                + case.distance.stops
                + case
                    .rounds
                    .iter()
                    .map(|round| round.rows.len())
                    .sum::<usize>()
        });
        let [certificates, loose] = [
            sum(&|case| case.work.certificates),
            sum(&|case| case.work.loose.len()),
        ];
        let [(overrun, most), (of_distances, most_of_distances)] = overruns(self.cases);
        vec![
            tested(
                "wrong",
                "Wrong answers",
                "Whenever a query is stopped, what it says is true: no wrong yes or no, no pair of triangles that does not \
                 meet, none twice, no distance outside of its bounds. A finished query has found all pairs.",
                format!("{wrong} wrong in {stops} stops."),
                wrong == 0,
            ),
            tested(
                "bounds",
                "What may have been missed",
                "A stopped query bounds what it may have missed: its bound on the number of pairs is never too low, and each \
                 missed pair meets in one of the boxes that it names.",
                format!(
                    "{loose} false in {certificates} certificates (one missed pair was looked up in each)."
                ),
                loose == 0,
            ),
            tested(
                "overrun",
                "Budgets of work",
                &format!(
                    "A budget of work is overrun by one step at most, {most} units, or {most_of_distances} of a distance query."
                ),
                format!("By {overrun} units at most, and {of_distances} of distance queries."),
                overrun <= most && of_distances <= most_of_distances,
            ),
        ]
    }
}

fn tested(id: &str, title: &str, claim: &str, measured: String, holds: bool) -> Section {
    let verdict = if holds {
        Verdict::Holds
    } else {
        Verdict::DoesNotHold
    };
    Section {
        id: id.to_owned(),
        title: title.to_owned(),
        lead: Lead::Claim(claim.to_owned(), verdict),
        measured,
        blocks: vec![],
    }
}
