//! Single rays of punctual against those of Embree 3: the same meshes and rays in the same run, one thread, turn by turn,
//! for each block of rays the least time of several. `cargo run --release --features embree --bin rays -- MESH.obj ...`
//! (needs `libembree3`, on Debian `libembree-dev`).
//!
//! Coherent rays are a camera's, row by row; random ones begin in the box of the mesh, a fifth larger, and go anywhere. All
//! numbers are `f32`, so that both answer the same question. Embree's rays lie ready in its own format; it is asked with
//! `rtcIntersect1` and `rtcOccluded1`, best build quality, as fast as it can and with its robust flag. Ours are a `Query<Rays>`,
//! and a `Query<RayCast>` each. A ray `differs` if one hits and the other does not, or not the same triangle at another `t`.

mod embree;
mod sets;

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use embree::Embree;
use punctual::rays::{RayHit, RayMode};
use punctual::{Budget, Query, Ray, Stats, Tree, Workspace};

const BLOCK: usize = 500;
const TURNS: usize = 3;

const HEAD: &str = "mesh,rays,count,hit,batch_ns,embree_ns,robust_ns,ratio,ratio_robust,single_ns,any_ns,occluded_ns,\
                    occluded_robust_ns,any_ratio,any_ratio_robust,differs,differs_robust,nodes,tests";

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let alone = arguments.first().is_some_and(|first| first == "--alone");
    if alone {
        arguments.remove(0);
    }
    let count = match arguments.first().and_then(|first| first.parse().ok()) {
        Some(count) => {
            arguments.remove(0);
            count
        }
        None => 1_000_000,
    };
    if alone {
        return arguments
            .iter()
            .for_each(|file| cast_alone(Path::new(file), count));
    }
    println!("{HEAD}");
    let mut logs = Vec::new();
    for file in &arguments {
        let case = Case::load(Path::new(file));
        for (name, rays) in sets::all(case.tree.mesh(), count) {
            logs.push((name, case.compare(name, &rays)));
        }
    }
    for (name, _) in sets::all(&punctual::shapes::icosphere(0), 1) {
        let of_set = logs.iter().filter(|(set, _)| *set == name);
        let mean = |k: usize| {
            let logs: Vec<f64> = of_set.clone().map(|(_, ratios)| ratios[k].ln()).collect();
            (logs.iter().sum::<f64>() / logs.len() as f64).exp()
        };
        let [fast, robust, any, any_robust] = [0, 1, 2, 3].map(mean);
        println!(
            "# {name}: geometric means {fast:.3}, robust {robust:.3}; any {any:.3}, robust {any_robust:.3}"
        );
    }
}

struct Case {
    name: String,
    tree: Tree,
}

/// The least time of each contender for one block, in nanoseconds, over all turns.
#[derive(Default)]
struct Least([f64; 7]);

impl Least {
    fn time(&mut self, which: usize, turn: usize, work: impl FnOnce()) {
        let start = Instant::now();
        work();
        let took = start.elapsed().as_nanos() as f64;
        let least = &mut self.0[which];
        *least = if turn == 0 { took } else { least.min(took) };
    }
}

impl Case {
    fn load(file: &Path) -> Self {
        let name = file
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let mesh = punctual_io::load(file)
            .unwrap_or_else(|error| panic!("{error}"))
            .mesh;
        Self {
            name,
            tree: Tree::new(mesh),
        }
    }

    /// Prints a row; Embree's time over ours: nearest, the same robust, any, the same robust.
    fn compare(&self, set: &str, rays: &[Ray]) -> [f64; 4] {
        let peers = [false, true].map(|robust| Embree::new(self.tree.mesh(), robust));
        let mut workspace = Workspace::new();
        let (mut sums, mut hit, mut differ, mut nodes, mut tests) = ([0.0; 7], 0, [0; 2], 0, 0);
        for block in rays.chunks(BLOCK) {
            let mut least = Least::default();
            let asked = embree::rays(block);
            for turn in 0..TURNS {
                let batch = Query::rays(&self.tree, block);
                least.time(4, turn, || {
                    black_box(batch.any().run(&mut workspace, Budget::unlimited()).value);
                });
                for (which, peer) in peers.iter().enumerate() {
                    let (mut shadows, mut nearest) = (asked.clone(), asked.clone());
                    least.time(5 + which, turn, || peer.occluded(black_box(&mut shadows)));
                    least.time(1 + which, turn, || peer.nearest(black_box(&mut nearest)));
                    if turn == 0 {
                        let _ = batch.run(&mut workspace, Budget::unlimited());
                        differ[which] += embree::differing(workspace.first_hits(), &nearest);
                    }
                }
                least.time(3, turn, || {
                    for &ray in block {
                        let query = Query::ray(&self.tree, ray);
                        black_box(query.run(&mut workspace, Budget::unlimited()).value.hit);
                    }
                });
                let mut done = None;
                least.time(0, turn, || {
                    done = Some(black_box(batch.run(&mut workspace, Budget::unlimited())))
                });
                if let (0, Some(done)) = (turn, done) {
                    hit += workspace.first_hits().iter().flatten().count();
                    nodes += done.stats.bv_tests;
                    tests += done.stats.primitive_tests;
                }
            }
            sums.iter_mut()
                .zip(least.0)
                .for_each(|(sum, least)| *sum += least);
        }
        let count = rays.len() as f64;
        let [ours, fast, robust, single, any, occluded, occluded_robust] =
            sums.map(|sum| sum / count);
        let ratios = [
            fast / ours,
            robust / ours,
            occluded / any,
            occluded_robust / any,
        ];
        println!(
            "{},{set},{count},{:.3},{ours:.1},{fast:.1},{robust:.1},{:.3},{:.3},{single:.1},{any:.1},{occluded:.1},\
             {occluded_robust:.1},{:.3},{:.3},{},{},{:.2},{:.2}",
            self.name,
            f64::from(hit as u32) / count,
            ratios[0],
            ratios[1],
            ratios[2],
            ratios[3],
            differ[0],
            differ[1],
            nodes as f64 / count,
            tests as f64 / count,
        );
        ratios
    }
}

/// Ours alone, once: for profiles, and to see that two builds give the same bits.
fn cast_alone(file: &Path, count: usize) {
    let case = Case::load(file);
    let mut workspace = Workspace::new();
    for (name, rays) in sets::all(case.tree.mesh(), count) {
        let batch = Query::rays(&case.tree, &rays);
        for (mode, batch) in [(RayMode::Nearest, batch), (RayMode::Any, batch.any())] {
            let stats = batch.run(&mut workspace, Budget::unlimited()).stats;
            case.print(name, mode.to_string(), workspace.first_hits(), &stats);
        }
        let cast = |&ray: &Ray| {
            let query = Query::ray(&case.tree, ray);
            query.run(&mut workspace, Budget::unlimited()).value.hit
        };
        let hits: Vec<_> = rays.iter().map(cast).collect();
        case.print(name, "single".to_owned(), &hits, &Stats::default());
    }
}

impl Case {
    fn print(&self, set: &str, mode: String, hits: &[Option<RayHit>], stats: &Stats) {
        let mix = |sum: u64, bits: u64| {
            (sum ^ bits)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(31)
        };
        let bits = |hit: &RayHit| [u64::from(hit.triangle), hit.t.to_bits(), hit.side as u64];
        let sum = hits.iter().flatten().flat_map(bits).fold(0, mix);
        let Stats {
            bv_tests,
            primitive_tests,
            exact_tests,
            work,
            ..
        } = stats;
        let found = hits.iter().flatten().count();
        println!(
            "{},{set},{mode},{found},{sum:016x},{bv_tests},{primitive_tests},{exact_tests},{work}",
            self.name
        );
    }
}
