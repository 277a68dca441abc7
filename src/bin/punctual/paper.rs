//! `punctual paper`: the experiments of Weller, Klein and Zachmann (2006) again, and the step beyond them.

mod delta;
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
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};

use crate::Completion;
use crate::report::{self, Block, Draw, Failure, Page, Picture, Section};
use ladder::Ladder;
use sample::Effort;

/// Reproduce the experiments of the paper that the cost model comes from.
///
/// Writes to a folder: index.html, which sets each claim, our measurement and the verdict side by side and needs no other
/// file; the plots as .svg and .png; and their numbers as .csv. The same options give the same files. Prints a line for
/// each claim.
#[derive(clap::Args)]
pub struct Args {
    /// Folder for the report; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A ladder for Figure 4: one shape at rising resolution, files separated by commas. May be repeated; without it,
    /// built-in shapes are used.
    #[arg(long, value_name = "FILE,FILE...")]
    meshes: Vec<String>,
    /// A smaller report with more noise, in seconds.
    #[arg(long)]
    quick: bool,
}

/// What every experiment needs: how much work to spend, and where results go.
pub struct Lab<'a> {
    folder: &'a Path,
    quick: bool,
    progress: ProgressBar,
}

impl Lab<'_> {
    /// How often artificial trees are sampled.
    fn effort(&self) -> Effort {
        if self.quick {
            Effort { tests: 400_000, least: 8, most: 400 }
        } else {
            Effort { tests: 30_000_000, least: 32, most: 4000 }
        }
    }

    /// `full`, or `quick` in a quick report.
    fn choose<T>(&self, full: T, quick: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Writes a plot and returns it for the page.
    fn plot(&self, name: &str, drawing: &impl Draw) -> Result<Block, Failure> {
        let picture = Picture::render(drawing)?;
        picture.write(self.folder, name)?;
        Ok(Block::from(&picture))
    }

    fn csv(&self, name: &str, header: &str, rows: &[Vec<String>]) -> Result<(), Failure> {
        report::write_csv(self.folder, name, header, rows)
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

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let ladders: Vec<Ladder> = if args.meshes.is_empty() {
        ladder::built_in(args.quick)
    } else {
        args.meshes.iter().map(|files| ladder::load(files)).collect::<Result<_, _>>()?
    };
    report::create_folder(&args.out)?;
    let style = ProgressStyle::with_template("{msg:10} {bar:40} {pos}/{len} {elapsed}")?;
    let lab = Lab { folder: &args.out, quick: args.quick, progress: ProgressBar::new(0).with_style(style) };
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
        experiment("delta", &|| delta::on_artificial_trees(&lab))?,
        experiment("meshes", &|| delta::on_meshes(&lab, &ladders))?,
    ];
    lab.progress.finish_and_clear();
    let page = page(sections, args.quick);
    report::write(&args.out.join("index.html"), page.html())?;
    for Section { title, verdict, measured, .. } in &page.sections {
        writeln!(out, "{title}: {}. {measured}", verdict.text())?;
    }
    Ok(Completion::Full)
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
    Page { title: "Expected cost of collision detection: the paper's claims, measured".to_owned(), intro, sections }
}
