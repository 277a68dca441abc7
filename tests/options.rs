//! Whatever a tree was built with, it is sound, it answers the same, and threads do not change a bit of it.

mod common;

use common::check::{ENOUGH, run, sorted};
use common::random::{Drift, Random, pose_about};
use punctual::glam::DVec3;
use punctual::tree::Effort;
use punctual::{Answer, BuildOptions, Query, Tree, Verdict, Workspace, shapes};

fn answer(a: &Tree, b: &Tree, seed: u64) -> (Answer<Verdict>, Vec<[u32; 2]>) {
    let pose = pose_about(DVec3::ZERO, 0.3, Drift::None, &mut Random::new(seed));
    let mut workspace = Workspace::new();
    let outcome = run(&Query::all_pairs(a, b, pose), &mut workspace, ENOUGH);
    (outcome, sorted(workspace.pairs()))
}

fn presets() -> [BuildOptions; 2] {
    [BuildOptions::fast_build(), BuildOptions::default()]
}

#[test]
fn presets_answer_the_same_and_more_effort_means_less_work() {
    let meshes = [
        shapes::torus_knot(2, 3, 0.2, 48),
        shapes::gear(17, 3),
        shapes::height_field(40, 3),
    ];
    let mut work = [0; 2];
    for mesh in &meshes {
        let other = Tree::new(shapes::icosphere(3));
        let trees = presets().map(|options| Tree::with_options(mesh.clone(), &options));
        for seed in 0..20 {
            let answers = trees.each_ref().map(|tree| answer(tree, &other, seed));
            assert_eq!(answers[0].1, answers[1].1);
            for (sum, (outcome, _)) in work.iter_mut().zip(&answers) {
                *sum += outcome.stats.work;
            }
        }
        trees.iter().for_each(|tree| tree.validate().unwrap());
    }
    assert!(work.is_sorted_by(|a, b| a >= b), "{work:?}");
}

#[test]
fn options_are_what_their_names_say() {
    let [fast, default] = presets();
    assert_eq!(
        [fast, default].map(|o| o.effort),
        [Effort::Fast, Effort::Normal]
    );
    assert!(
        [fast, default]
            .iter()
            .all(|o| o.orientations && o.threads == 1)
    );
    assert_eq!(default.threads(5).threads, 5);
}

/// Compared by all that can be seen of every node. Without the feature `parallel` threads are one.
#[test]
fn any_number_of_threads_builds_the_same_tree() {
    let mesh = shapes::torus_knot(3, 5, 0.15, 480);
    assert!(mesh.len() > 50_000, "{}", mesh.len());
    for options in presets() {
        let one = Tree::with_options(mesh.clone(), &options);
        for threads in [0, 2, 3, 16] {
            let many = Tree::with_options(mesh.clone(), &options.threads(threads));
            assert_eq!(many.stats(), one.stats());
            let mut pairs = vec![(one.root().unwrap(), many.root().unwrap())];
            while let Some((one, many)) = pairs.pop() {
                assert_eq!(
                    (many.rotation(), many.half_extents()),
                    (one.rotation(), one.half_extents())
                );
                assert_eq!(
                    (many.alpha(), many.self_cost()),
                    (one.alpha(), one.self_cost())
                );
                assert!(many.triangles().eq(one.triangles()));
                pairs.extend(one.children().zip(many.children()));
            }
            assert_eq!(answer(&many, &one, 1), answer(&one, &one, 1));
        }
    }
}
