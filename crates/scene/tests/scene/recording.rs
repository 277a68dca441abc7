//! A recorded scene is played again to the bit; damaged files are refused with their place.
#![cfg(all(feature = "parallel", feature = "record"))]

use crate::{ball, moving};
use std::io::{self, Write};
use std::sync::{Arc, Mutex};

use punctual::glam::DVec3;
use punctual::prediction::Calibration;
use punctual::{Budget, Pose, Tree};
use punctual_scene::{Replay, Scene};

use crate::common::random::Random;
use crate::lock_step::said;
use crate::world::World;

/// A file that can be read while a scene writes it.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap().clone()
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A recorded world after `frames` frames with random changes, and what each frame said.
fn recorded(seed: u64, frames: usize) -> (Shared, Vec<String>) {
    let file = Shared::default();
    let mut world = World::new(seed, DVec3::ZERO);
    world.scene = Scene::recorded(file.clone());
    world.scene.track_contacts();
    world.scene.reserve(20, 50);
    let told = (0..frames).map(|_| {
        for _ in 0..world.random.below(8) {
            world.change();
            further_change(&mut world);
        }
        let budget = match world.random.below(4) {
            0 => Budget::unlimited(),
            _ => Budget::work(1 << (8 + world.random.below(10))),
        };
        world.scene.detect(budget);
        said(&world.scene)
    });
    let told = told.collect();
    world.scene.stop_recording().unwrap();
    (file, told)
}

/// The calls that a world does not make.
fn further_change(world: &mut World) {
    let (scene, random) = (&mut world.scene, &mut world.random);
    let ids: Vec<_> = scene.bodies().map(|(id, _)| id).collect();
    let [x, y] = [0; 2].map(|_| ids[random.below(ids.len())]);
    let groups = ["walls", "hands"].map(|name| scene.group(name));
    match random.below(12) {
        0 => scene.set_group(x, [Some(groups[0]), None][random.below(2)]),
        1 => scene.ignore_groups(groups[0], groups[random.below(2)], random.below(2) == 0),
        2 if x != y => scene.ignore(x, y, random.below(2) == 0),
        3 => scene.set_look_ahead(0.1 * random.unit()),
        4 => scene.set_name(x, "a \"name\"\nof two lines"),
        5 => {
            *scene.tree_mut(x).unwrap() = Tree::clone(&world.trees[random.below(3)]);
            Ok(())
        }
        6 => {
            // The tree of another body after a refit, which shares what is known of that.
            let mut tree = Tree::clone(&scene.body(x).unwrap().tree);
            let mesh = tree.mesh();
            let vertices = (0..mesh.vertex_count()).map(|i| (0.97 * mesh.vertex(i)).to_array());
            let vertices: Vec<_> = vertices.collect();
            tree.refit_f64(&vertices).unwrap();
            scene.set_tree(y, Arc::new(tree))
        }
        7 if random.below(4) == 0 => {
            scene.set_calibration(Calibration::default());
            Ok(())
        }
        _ => {
            // It is not in the file.
            assert!(scene.set_margin(x, f64::NAN).is_err());
            Ok(())
        }
    }
    .unwrap();
}

#[test]
fn a_replay_says_in_each_frame_what_the_recorded_scene_said_on_any_number_of_threads() {
    for seed in 0..8 {
        let (file, told) = recorded(seed, 60);
        for threads in [1, 2] {
            let (bytes, mut scene) = (file.bytes(), Scene::new());
            scene.use_threads(threads).unwrap();
            let mut replay = Replay::new(&bytes[..]);
            for (frame, told) in told.iter().enumerate() {
                let budget = replay.next_frame(&mut scene).unwrap().unwrap();
                scene.detect(budget);
                assert!(said(&scene) == *told, "{seed} {frame} {threads}");
            }
            assert!(replay.next_frame(&mut scene).unwrap().is_none());
        }
    }
}

fn play(bytes: &[u8]) -> Result<usize, String> {
    let (mut replay, mut scene, mut frames) = (Replay::new(bytes), Scene::new(), 0);
    while let Some(budget) = replay
        .next_frame(&mut scene)
        .map_err(|error| error.to_string())?
    {
        // The budget may be damaged too.
        scene.detect(Budget::work(budget.work_limit().unwrap_or(0).min(1000)));
        frames += 1;
    }
    Ok(frames)
}

#[test]
fn a_recording_that_was_cut_or_damaged_is_refused_with_its_place() {
    let (file, told) = recorded(9, 12);
    let bytes = file.bytes();
    assert_eq!(play(&bytes), Ok(told.len()));
    let text = String::from_utf8(bytes.clone()).unwrap();
    let lines: Vec<_> = text.lines().collect();
    let cut = play(&bytes[..bytes.len() - 5]).unwrap_err();
    assert!(cut.contains(&format!("line {}", lines.len())), "{cut}");
    let without = |what| {
        let left = lines.iter().filter(|line| !line.starts_with(what));
        left.map(|line| format!("{line}\n")).collect()
    };
    let refused: [(String, &str); 5] = [
        ("not a recording".into(), "line 1"),
        (
            text.replacen("insert", "inserted", 1),
            "unknown variant `inserted`",
        ),
        (
            text.replacen("\"tree\":\"", "\"tree\":\"AAAA", 1),
            "call before byte",
        ),
        (without("{\"tree\""), "no tree 0"),
        (without("{\"insert\""), "is not in the scene"),
    ];
    for (text, named) in refused {
        let error = play(text.as_bytes()).unwrap_err();
        assert!(error.contains(named), "{named}: {error}");
    }
    let mut random = Random::new(3);
    for _ in 0..200 {
        let mut damaged = bytes.clone();
        let at = random.below(damaged.len());
        damaged[at] = random.bits() as u8;
        // Another number, and lines in another order, may be as good as the first; none panics.
        let _ = play(&damaged);
        let _ = play(&damaged[..at]);
        let mut lines = lines.clone();
        let [from, to, gone] = [0; 3].map(|_| random.below(lines.len()));
        lines.swap(from, to);
        lines.remove(gone);
        let _ = play(lines.join("\n").as_bytes());
    }
}

#[test]
fn a_file_that_cannot_be_written_ends_the_recording_and_not_the_scene() {
    /// Takes so many bytes.
    struct Full(usize);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 = self
                .0
                .checked_sub(bytes.len())
                .ok_or(io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let ball = ball(1);
    for room in [0, 100, 3000, 100_000] {
        let mut scene = Scene::recorded(Full(room));
        for _ in 0..2 {
            moving(&mut scene, &ball, Pose::IDENTITY);
        }
        assert_eq!(scene.detect(Budget::unlimited()).intersecting, 1);
        let ended = scene.stop_recording();
        assert_eq!(ended.is_ok(), room == 100_000);
        assert!(scene.stop_recording().is_ok());
    }
}
