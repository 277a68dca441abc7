//! `punctual poses`.

use punctual::shapes::{cuboid, icosphere, torus};

use crate::run::Folder;
use crate::write;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&torus(1.0, 0.3, 24)));
    folder.write("b.obj", write::obj(&icosphere(2)));
    // Its walls alone, of two sides each.
    folder.write("room.obj", write::obj(&cuboid([9.0; 3], 4)));
    folder
}

/// Makes poses, checks that they are so many and the same a second time, and returns the lines.
fn made(folder: &Folder, options: &str, count: usize) -> String {
    let answer = folder.ok(&format!("poses {options}"));
    assert_eq!(
        answer
            .out
            .lines()
            .filter(|line| !line.starts_with('#'))
            .count(),
        count,
        "{options}"
    );
    assert_eq!(answer.out, folder.run(&format!("poses {options}")).out);
    assert_ne!(
        answer.out,
        folder.run(&format!("poses {options} --seed 2")).out,
        "{options}"
    );
    answer.out
}

/// How many of these poses meet, and all rows of `punctual pair`.
fn hits(folder: &Folder, meshes: &str, poses: &str) -> Vec<bool> {
    folder.write("poses.txt", poses);
    let answer = folder.run(&format!("pair {meshes} poses.txt"));
    assert_eq!(answer.status, 0, "{}", answer.err);
    answer.rows().iter().map(|row| row.hit == "1").collect()
}

#[test]
fn poses_near_contact_lie_on_the_side_that_they_say() {
    let folder = folder();
    for (meshes, options) in [("a.obj b.obj", ""), ("room.obj b.obj", "--inside")] {
        let poses = made(&folder, &format!("{meshes} --contact 33 {options}"), 33);
        let met = hits(&folder, meshes, &poses);
        let offsets: Vec<f64> = poses
            .lines()
            .filter_map(|line| {
                line.strip_prefix("# approach=")?
                    .split_once("offset=")?
                    .1
                    .strip_suffix('%')?
                    .parse()
                    .ok()
            })
            .collect();
        assert_eq!(offsets.len(), 33);
        for (i, (offset, met)) in offsets.iter().zip(&met).enumerate() {
            // Just before the first touch nothing meets, and just behind it something does.
            assert!(*offset < 0.0 || !met, "{meshes} {i} {offset}");
            assert!(*offset != -0.1 || *met, "{meshes} {i} {offset}");
        }
    }
}

#[test]
fn a_rolling_body_touches_in_about_half_of_its_frames() {
    let folder = folder();
    let poses = made(&folder, "a.obj b.obj --roll 100", 100);
    let count = hits(&folder, "a.obj b.obj", &poses)
        .into_iter()
        .filter(|met| *met)
        .count();
    assert!((20..=80).contains(&count), "{count}");
    for few in [1, 2] {
        made(&folder, &format!("a.obj b.obj --roll {few}"), few);
    }
}

#[test]
fn random_poses_meet_and_do_not() {
    let folder = folder();
    let met = hits(
        &folder,
        "a.obj b.obj",
        &made(&folder, "a.obj b.obj --random 60", 60),
    );
    assert!(met.contains(&true) && met.contains(&false));
}

#[test]
fn poses_that_cannot_be_made_are_refused() {
    let folder = folder();
    folder.refuses(
        "poses a.obj",
        &[
            ("b.obj", "--contact <N>|--roll <N>|--random <N>"),
            ("b.obj --contact 3 --roll 3", "cannot be used with"),
            ("b.obj --roll 3 --inside", "--inside cannot be used"),
            ("none.obj --roll 3", "none.obj"),
        ],
    );
    // Specks at two ends of a box, which no line hits.
    let speck = |x: f32| {
        format!(
            "v {x} {x} {x}\nv {} {x} {x}\nv {x} {} {x}\n",
            x + 1e-6,
            x + 1e-6
        )
    };
    folder.write(
        "specks.obj",
        format!("{}{}f 1 2 3\nf 4 5 6\n", speck(0.0), speck(1.0)),
    );
    folder.write("speck.obj", format!("{}f 1 2 3\n", speck(0.0)));
    folder.refused(
        "poses specks.obj speck.obj --contact 3",
        &["none of", "lines in a row"],
    );
}
