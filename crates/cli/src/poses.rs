//! `punctual poses`: poses at which two meshes come close, to try and to measure with.

use std::io::Write;
use std::path::PathBuf;

use punctual::BuildOptions;
use punctual::glam::DMat3;
use punctual_lab::approach::{Approach, Line, OFFSETS, contact, print, random};
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::MeshArgs;

/// Make poses of mesh B in the frame of mesh A: near contact, rolling over each other, or at random.
///
/// Prints the poses for the other commands: 12 numbers a line, the rows of [R|t]; lines that begin with `#` are comments.
/// The same meshes, numbers and seed give the same poses. For `punctual sweep`, a folder with the meshes as a.* and b.*
/// and these lines as poses.txt is a case.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("kind").required(true))]
pub struct Args {
    /// Mesh A, which stays as it is in its file: .obj, .stl, .ply, .off, .glb, .gltf or .dae, or one of these with .gz; - is
    /// standard
    /// input, whose format its content tells.
    a: PathBuf,
    /// Mesh B, which takes the poses.
    b: PathBuf,
    /// N poses near contact. B, turned at random, comes from outside along random lines through the box of A; seven
    /// poses of
    /// each line lie 5, 2, .5 and .1 % past the first touch, and .1, .5 and 2 % before it. Percents are of the box
    /// diagonal of
    /// the smaller mesh.
    #[arg(long, value_name = "N", group = "kind")]
    contact: Option<usize>,
    /// N frames of a motion: B goes once around A and turns, at the distance of its first touch smoothed over a 32nd of
    /// the frames.
    #[arg(long, value_name = "N", group = "kind")]
    roll: Option<usize>,
    /// N poses at random: any turn, and any place at which the balls around the boxes of the meshes overlap.
    #[arg(long, value_name = "N", group = "kind")]
    random: Option<usize>,
    /// Begin the lines of --contact within the box of A, where B touches nothing: for rooms.
    #[arg(long, conflicts_with_all = ["roll", "random"])]
    inside: bool,
    /// Another seed gives other poses.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    meshes: MeshArgs,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let tree = |file| args.meshes.tree(file, &BuildOptions::default());
    let ((a, _), (b, _)) = (tree(&args.a)?, tree(&args.b)?);
    let mut approach = Approach::new(&a, &b, args.seed);
    // All or nothing.
    let mut lines = Vec::new();
    match (args.contact, args.roll, args.random) {
        (Some(count), ..) => {
            writeln!(
                lines,
                "# offset: before the first touch, in percent of the box diagonal of the smaller mesh"
            )?;
            let poses = contact(&mut approach, count, args.inside, &OFFSETS)?;
            for (i, pose) in poses.iter().enumerate() {
                let (line, offset) = (i / OFFSETS.len(), OFFSETS[i % OFFSETS.len()]);
                writeln!(lines, "# approach={line} offset={offset}%")?;
                print(pose, &mut lines)?;
            }
        }
        (_, Some(frames), _) => roll(&mut approach, frames, &mut lines)?,
        (.., count) => {
            for pose in random(&mut approach, count.unwrap_or(0))? {
                print(&pose, &mut lines)?;
            }
        }
    }
    out.write_all(&lines)?;
    Ok(Completion::Full)
}

/// Frames in which B turns on its way around A.
fn roll(approach: &mut Approach, frames: usize, out: &mut impl Write) -> Result<(), Failure> {
    let turn = approach.turn();
    let [around_a, around_b, start] = [(); 3].map(|()| approach.direction());
    let start = around_a
        .any_orthonormal_vector()
        .lerp(start, 0.25)
        .normalize();
    let mut touches = Vec::new();
    let lines: Vec<Line> = (0..frames)
        .map(|frame| {
            let angle = std::f64::consts::TAU * frame as f64 / frames as f64;
            let turn = DMat3::from_axis_angle(around_b, 2.0 * angle) * turn;
            let direction = DMat3::from_axis_angle(around_a, angle) * start;
            Line {
                turn,
                target: approach.middle_of_a(),
                direction,
            }
        })
        .collect();
    for line in &lines {
        let touch = approach.first_touch(line, approach.reach())?;
        // Where B passes A it goes on as it was.
        touches.push(touch.or(touches.last().copied()).unwrap_or(0.0));
    }
    let half = (frames / 64).max(1).min(frames);
    writeln!(
        out,
        "# depth: past the first touch, in percent of the box diagonal of the smaller mesh"
    )?;
    for (frame, line) in lines.iter().enumerate() {
        // The path is closed.
        let near = (0..=2 * half).map(|i| touches[(frame + frames + i - half) % frames]);
        let distance = near.sum::<f64>() / (2 * half + 1) as f64;
        writeln!(
            out,
            "# depth={:.3}%",
            100.0 * (touches[frame] - distance) / approach.unit()
        )?;
        print(&approach.at(line, distance)?, out)?;
    }
    Ok(())
}
