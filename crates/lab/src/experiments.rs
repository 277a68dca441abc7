//! The experiments of Weller, Klein and Zachmann (2006) again, and the step beyond them.

mod equation11;
mod figure4;
mod figure5;
mod figure6;
mod figure7;
mod ladder;
mod mesh_tree;
mod sample;
mod spread;
mod table1;

use std::io::Write;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

use crate::fit::PowerLaw;
use crate::report::{self, Block, Draw, Failure, Lead, Page, Section};
use ladder::Ladder;
use sample::Effort;

/// What is measured, and where it is written to.
pub struct Settings<'a> {
    /// Folder for the report; made if it does not exist.
    pub folder: &'a Path,
    /// Ladders for Figure 4: one shape at rising resolution, files separated by commas. Without any, built-in shapes.
    pub ladders: &'a [String],
    /// A smaller report with more noise, in seconds.
    pub quick: bool,
}

/// What every experiment needs: how much work to spend, and where results go.
struct Lab<'a> {
    folder: &'a Path,
    quick: bool,
    progress: ProgressBar,
}

impl Lab<'_> {
    /// How often artificial trees are sampled.
    fn effort(&self) -> Effort {
        if self.quick {
            Effort {
                tests: 400_000,
                least: 8,
                most: 400,
            }
        } else {
            Effort {
                tests: 30_000_000,
                least: 32,
                most: 4000,
            }
        }
    }

    /// `full`, or `quick` in a quick report.
    fn choose<T>(&self, full: T, quick: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Writes a plot and returns it for the page.
    fn plot(&self, name: &str, drawing: &impl Draw) -> Result<Block, Failure> {
        report::plot(self.folder, name, drawing)
    }

    /// Writes a table of numbers.
    fn csv<const N: usize>(
        &self,
        name: &str,
        header: &str,
        rows: impl IntoIterator<Item = [f64; N]>,
    ) -> Result<(), Failure> {
        let row = |row: [f64; N]| row.map(|x| x.to_string()).to_vec();
        let rows: Vec<_> = rows.into_iter().map(row).collect();
        report::write_csv(self.folder, name, header, &rows)
    }

    /// Computes `run` of all items on all cores; results in the order of the items.
    fn all<I: Sync, O: Send>(&self, items: &[I], run: impl Fn(&I) -> O + Sync) -> Vec<O> {
        self.progress.inc_length(items.len() as u64);
        sample::parallel(items, |item| {
            let result = run(item);
            self.progress.inc(1);
            result
        })
    }
}

/// Leaves of a binary tree.
fn leaves(depth: u32) -> f64 {
    f64::from(depth).exp2()
}

/// The exponent of the power law through the last of some points.
fn exponent(points: &[[f64; 2]], last: usize) -> f64 {
    PowerLaw::fit(&points[points.len() - last..]).map_or(f64::NAN, |law| law.exponent())
}

/// Measures every claim of the paper, writes the report, and prints a line for each claim.
///
/// The report is `index.html`, which sets each claim, what was measured and the verdict side by side and needs no other
/// file; its plots as `.svg`, and their numbers as `.csv`. The same settings give the same files.
///
/// # Errors
/// If a mesh cannot be read or a file cannot be written; the message names it.
pub fn run(settings: &Settings<'_>, out: &mut impl Write) -> Result<(), Failure> {
    let &Settings { folder, quick, .. } = settings;
    let ladders: Vec<Ladder> = if settings.ladders.is_empty() {
        ladder::built_in(quick)
    } else {
        settings
            .ladders
            .iter()
            .map(|files| ladder::load(files))
            .collect::<Result<_, _>>()?
    };
    report::create_folder(folder)?;
    let style = ProgressStyle::with_template("{msg:10} {bar:40} {pos}/{len} {elapsed}")?;
    let lab = Lab {
        folder,
        quick,
        progress: ProgressBar::new(0).with_style(style),
    };
    let experiment = |name: &'static str, run: &dyn Fn() -> Result<Section, Failure>| {
        lab.progress.set_message(name);
        run()
    };
    let sections = vec![
        experiment("Table 1", &|| table1::run(&lab))?,
        experiment("Eq 11", &|| equation11::run(&lab))?,
        experiment("Figure 4", &|| figure4::run(&lab, &ladders))?,
        experiment("Figure 5", &|| figure5::run(&lab))?,
        experiment("Figure 6", &|| figure6::run(&lab))?,
        experiment("Figure 7", &|| figure7::run(&lab))?,
        experiment("spread", &|| spread::run(&lab))?,
    ];
    lab.progress.finish_and_clear();
    let page = page(sections, quick);
    report::write(&folder.join("index.html"), page.html())?;
    for Section {
        title,
        lead,
        measured,
        ..
    } in &page.sections
    {
        if let Lead::Claim(_, verdict) = lead {
            writeln!(out, "{title}: {}. {measured}", verdict.text())?;
        }
    }
    Ok(())
}

fn page(sections: Vec<Section>, quick: bool) -> Page {
    let mut intro = vec![
        "The claims are those of R. Weller, J. Klein, G. Zachmann: A Model for the Expected Running Time of Collision \
         Detection using AABB Trees (EGVE 2006). N_v is the number of pairs of boxes that overlap, n the number of leaves \
         (triangles) of each of two trees, alpha the factor by which boxes shrink from one level of a binary tree to the \
         next, delta the overlap of the root boxes along x, as a fraction of their extent."
            .to_owned(),
        "Artificial trees are the paper's: every child alpha times its parent along each axis, children in opposite \
         corners of their parent, n a power of two, roots offset by 1 - delta along x and at random along y and z under \
         the condition that they meet. All random numbers have fixed seeds."
            .to_owned(),
    ];
    if quick {
        intro.push(
            "A quick report: few samples, small trees. Its verdicts are for testing the program only.".to_owned(),
        );
    }
    Page {
        title: "Expected cost of collision detection: the paper's claims, measured".to_owned(),
        intro,
        sections,
    }
}
