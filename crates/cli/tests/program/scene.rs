//! `punctual scene` from outside.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::sync::Arc;

use flate2::Compression;
use flate2::write::GzEncoder;
use punctual::shapes::icosphere;
use punctual::{Budget, Pose, Tree};
use punctual_scene::{Body, Scene};

use crate::run::{Answer, Folder};
use crate::view::Page;
use crate::write;

const FRAMES: usize = 12;

/// Three balls: one fixed, one that goes through it, one that follows two behind.
fn recording() -> Folder {
    let folder = Folder::new();
    folder.write("ball.obj", write::obj(&icosphere(2)));
    folder.write(
        "scene.txt",
        "# balls\nmesh 0 ball.obj\nbody 0 0 static\nbody 1 0 moving\nbody 2 0 moving\n",
    );
    let (mut poses, mut truth) = (
        String::from("frame,body,px,py,pz,qw,qx,qy,qz\n"),
        GzEncoder::new(Vec::new(), Compression::fast()),
    );
    writeln!(truth, "frame,a,b").unwrap();
    for frame in 0..FRAMES {
        let x = 3.0 - 0.5 * frame as f64;
        for (body, x) in [0.0, x, x + 2.5].into_iter().enumerate() {
            poses += &format!("{frame},{body},{x},0.1,0,1,0,0,0\n");
        }
        // Balls one inside the other do not meet; where they nearly touch, nothing is asked.
        let meets = |x: f64| x.abs() > 0.2 && x.abs() < 1.9;
        [x, x + 2.5]
            .into_iter()
            .zip(1..)
            .filter(|&(x, _)| meets(x))
            .for_each(|(_, body)| {
                writeln!(truth, "{frame},0,{body}").unwrap();
            });
    }
    folder.write("poses.csv", poses);
    folder.write("truth_pairs.csv.gz", truth.finish().unwrap());
    folder
}

/// The figure `name=...` of a summary line.
fn figure(output: &str, name: &str) -> f64 {
    let mut words = output
        .lines()
        .filter(|line| line.starts_with('#'))
        .flat_map(str::split_whitespace);
    let value = words
        .find_map(|word| word.strip_prefix(name)?.strip_prefix('='))
        .unwrap();
    value.parse().unwrap()
}

fn rows(output: &str) -> Vec<Vec<u64>> {
    let lines = output.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().unwrap())
                .collect()
        })
        .collect()
}

#[test]
fn a_page_shows_in_each_frame_which_bodies_meet() {
    let folder = recording();
    folder.ok("scene . --view page.html");
    let page = Page::read(&folder, "page.html");
    page.assert_shows(0, &icosphere(2));
    assert_eq!(page.steps().len(), FRAMES);
    for (frame, step) in page.steps().iter().enumerate() {
        // As in the recording: the first ball is fixed, and the second is well inside the way of meeting it or not.
        let x = 3.0 - 0.5 * frame as f64;
        let layer = |body: usize| step["surfaces"][body][0].as_str().unwrap();
        assert_eq!(layer(0), "fixed");
        if x.abs() > 0.2 && (x.abs() < 1.9 || x.abs() > 2.1) {
            assert_eq!(
                layer(1),
                if x.abs() < 1.9 { "b" } else { "a" },
                "frame {frame}"
            );
        }
    }
    folder.run("scene . --budget-work 0 --view page.html");
    let undecided = |step: &serde_json::Value| {
        step["surfaces"]
            .as_array()
            .unwrap()
            .iter()
            .any(|s| s[0] == "doubt")
    };
    assert!(
        Page::read(&folder, "page.html")
            .steps()
            .iter()
            .any(undecided)
    );
}

#[test]
fn a_page_names_bodies_and_lists_the_pairs_that_meet_and_those_not_known() {
    let folder = recording();
    let mut listed = [0, 0];
    for budget in [0, 400, 1_000_000] {
        folder.run(&format!(
            "scene . --budget-work {budget} --pairs-out pairs.csv --view page.html"
        ));
        let page = Page::read(&folder, "page.html");
        assert_eq!(
            page.view["names"],
            serde_json::json!(["0: ball.obj", "1: ball.obj", "2: ball.obj"])
        );
        let pairs = table(&folder, "pairs.csv");
        for (frame, step) in page.steps().iter().enumerate() {
            for (list, verdict) in ["intersecting", "undecided"].into_iter().enumerate() {
                let wanted = pairs
                    .iter()
                    .filter(|line| line[0] == frame.to_string() && line[3] == verdict);
                let wanted: Vec<u32> = wanted
                    .flat_map(|line| [&line[1], &line[2]])
                    .map(|n| n.parse().unwrap())
                    .collect();
                assert_eq!(page.range(&step["pairs"][list]), wanted, "{frame}");
                listed[list] += wanted.len();
            }
            // A line for each pair of which it is not known.
            let lines = step["lines"]
                .as_array()
                .unwrap()
                .iter()
                .filter(|line| line[0] == "open");
            let drawn: usize = lines.map(|line| page.range(&line[1]).len() / 6).sum();
            assert_eq!(drawn, page.range(&step["pairs"][1]).len() / 2, "{frame}");
        }
    }
    assert!(listed.iter().all(|&pairs| pairs > 0), "{listed:?}");
}

#[test]
fn every_frame_has_a_line_and_the_truth_is_compared() {
    let folder = recording();
    for options in [
        "",
        "--threads 2",
        "--mode all",
        "--budget-work 100000000",
        "--clock cpu --reps 2",
    ] {
        let answer = folder.ok(&format!("scene . {options} --pairs-out pairs.csv"));
        let header =
            "frame,broad_pairs,decided,hits,undecided,wall_ns,cpu_ns,overrun_ns,bv_tests,work";
        assert_eq!(answer.out.lines().next(), Some(header));
        let rows = rows(&answer.out);
        assert_eq!(rows.len(), FRAMES);
        assert!(
            rows.iter()
                .all(|row| row[1] == row[2] && row[4] == 0 && row[3] <= row[1]),
            "{options}"
        );
        assert_eq!(figure(&answer.out, "share"), 1.0);
        assert_eq!(figure(&answer.out, "worst_age"), 0.0);
        let hits: u64 = rows.iter().map(|row| row[3]).sum();
        let pairs = folder.read("pairs.csv");
        assert_eq!(
            pairs.lines().next(),
            Some("frame,a,b,verdict,probability,age")
        );
        assert_eq!(
            pairs
                .lines()
                .filter(|line| line.ends_with(",intersecting,1.0000,0"))
                .count() as u64,
            hits
        );
    }
}

/// The lines of a CSV file, by columns.
fn table(folder: &Folder, file: &str) -> Vec<Vec<String>> {
    let text = folder.read(file);
    let lines: Vec<Vec<String>> = text
        .lines()
        .map(|line| line.split(',').map(String::from).collect())
        .collect();
    assert!(
        lines.iter().all(|line| line.len() == lines[0].len()),
        "{file}: {text}"
    );
    lines[1..].to_vec()
}

#[test]
fn a_scene_answers_all_its_questions() {
    let folder = recording();
    folder.write("rays.txt", "0 0 -5 0 0 1\n0 9 0 0 1 0\n");
    let asked = "--contacts --measure 0,1 --motions --events --rays rays.txt --answers told";
    let answer = folder.ok(&format!("scene . {asked} --reps 2"));
    let number = |field: &String| field.parse::<f64>().unwrap();
    // Where the middle of the ball is that goes through the fixed one.
    let x = |frame: f64| 3.0 - 0.5 * frame;

    let distances = table(&folder, "told/distances.csv");
    assert_eq!(distances.len(), FRAMES);
    for line in &distances {
        let [low, high] = [&line[3], &line[4]].map(number);
        let between = x(number(&line[0])).abs();
        // Balls of radius 1, of flat triangles; one inside the other is apart as well.
        assert!(
            low <= high && high - low < 1e-9 && line[7] == "0",
            "{line:?}"
        );
        assert!(
            between < 2.0 || (high - (between - 2.0)).abs() < 0.1,
            "{line:?}"
        );
    }

    let passages = table(&folder, "told/passages.csv");
    let touching = passages.iter().filter(|line| !line[4].is_empty()).count();
    assert_eq!(
        [passages.len(), touching].map(|n| n as f64),
        ["asked", "touching"].map(|n| last(&answer.out, "passages", n))
    );
    // The ball behind comes within reach of the fixed one on the way to the frame in which it meets it first.
    let begins = passages
        .iter()
        .find(|line| (&*line[1], &*line[2]) == ("0", "2") && !line[4].is_empty())
        .unwrap();
    assert!(
        (x(number(&begins[0]) + number(&begins[4])) + 2.5 - 2.0).abs() < 0.1,
        "{begins:?}"
    );

    let events = table(&folder, "told/events.csv");
    let phases = |name: &str| events.iter().filter(|line| line[3] == name).count() as f64;
    assert!(phases("began") > 0.0 && phases("persists") > 0.0);
    assert_eq!(
        ["began", "ended"].map(phases),
        ["began", "ended"].map(|name| last(&answer.out, "events", name))
    );

    let contacts = table(&folder, "told/contacts.csv");
    assert!(contacts.iter().any(|line| number(&line[0]) > 2.0));
    for line in &contacts {
        // Each point on its ball, in the coordinates of the scene.
        for (column, at) in [(1, 5), (2, 8)] {
            let body = number(&line[column]);
            let [px, py, pz] = [at, at + 1, at + 2].map(|at| number(&line[at]));
            let middle = if body == 0.0 {
                0.0
            } else {
                x(number(&line[0])) + 2.5 * (body - 1.0)
            };
            let radius = (px - middle).hypot(py - 0.1).hypot(pz);
            assert!((0.95..1.01).contains(&radius), "{line:?}");
        }
    }

    let hits = table(&folder, "told/hits.csv");
    assert_eq!(hits.len(), 2 * FRAMES);
    assert!(
        hits.iter()
            .all(|line| (line[1] == "1") == line[2].is_empty()),
        "{hits:?}"
    );
    assert!(
        hits.iter()
            .filter(|line| line[2] == "0")
            .all(|line| (number(&line[4]) - 4.0).abs() < 0.05)
    );
    assert_eq!(
        [
            last(&answer.out, "rays", "cast"),
            last(&answer.out, "rays", "hit")
        ],
        [24.0, 12.0]
    );

    folder.refused("scene . --measure 0,7", &["no body 7"]);
    folder.refused("scene . --measure 0", &["numbers of two bodies"]);
    folder.write("rays.txt", "0 0 -5 0 0 1\n0 0 0 0 0 0\n");
    folder.refused("scene . --rays rays.txt", &["rays.txt:2: "]);
}

/// The figure `name=...` of the summary line that begins with a word.
fn last(output: &str, line: &str, name: &str) -> f64 {
    let line = output
        .lines()
        .find(|told| told.starts_with(&format!("# {line} ")))
        .unwrap();
    figure(line, name)
}

#[test]
fn a_small_budget_leaves_pairs_undecided_and_says_so() {
    let folder = recording();
    let answer = folder.run("scene . --budget-work 700 --frames 10");
    let rows = rows(&answer.out);
    assert_eq!(rows.len(), 10);
    // Work beyond the budget.
    assert!(rows.iter().all(|row| row[9] <= 700));
    assert!(rows.iter().any(|row| row[4] > 0), "nothing undecided");
    assert!(figure(&answer.out, "worst_age") > 0.0);
    let late = folder.run("scene . --budget-us 0");
    assert!(late.out.lines().any(|line| line.starts_with("# frames=12")));
}

#[test]
fn a_plain_loop_finds_the_same_without_a_budget_and_less_with_one() {
    let folder = recording();
    let play = |options: &str| {
        let answer = folder.ok(&format!("scene . --clock cpu {options}"));
        rows(&answer.out)
    };
    let (scene, plain) = (play(""), play("--plain"));
    assert_eq!(scene.len(), plain.len());
    for (scene, plain) in scene.iter().zip(&plain) {
        assert_eq!(scene[..5], plain[..5]);
    }
    let cut = play("--plain --budget-work 100");
    assert!(
        cut.iter().any(|row| row[4] > 0)
            && cut
                .iter()
                .zip(&plain)
                .all(|(cut, plain)| cut[3] <= plain[3])
    );
    assert!(play("--plain --budget-us 0").iter().all(|row| row[2] == 0));
    folder.refused("scene . --plain", &["--clock cpu"]);
    folder.refused(
        "scene . --plain --clock cpu --contacts",
        &["only which bodies meet"],
    );
}

#[test]
fn faults_name_the_file_and_the_line() {
    let cases = [
        (
            "scene.txt",
            "mesh 0 ball.obj\nbody 1 0 moving\n",
            "scene.txt:2: body 1, must be 0",
        ),
        ("scene.txt", "body 0 4 moving\n", "scene.txt:1: no mesh 4"),
        (
            "scene.txt",
            "mesh 0\n",
            "scene.txt:1: must be `mesh ID FILE`",
        ),
        ("scene.txt", "mesh 0 absent.obj\n", "absent.obj: "),
        (
            "poses.csv",
            "header\n0,0,1,2,3,1,0,0,0\n0,2,1,2,3,1,0,0,0\n",
            "poses.csv:3: frame 0, body 2",
        ),
        (
            "poses.csv",
            "header\n0,0,1,2,3,0,0,0,0\n",
            "poses.csv:2: quaternion is zero",
        ),
        (
            "poses.csv",
            "header\n0,0,1,2\n",
            "poses.csv:2: fewer than 9 columns",
        ),
        (
            "poses.csv",
            "header\n0,0,1,2,3,1,0,0,0\n",
            "the last frame has 1 of 3 bodies",
        ),
        ("poses.csv", "header\n", "no frame in it"),
        (
            "truth_pairs.csv",
            "frame,a,b\n99,0,1\n",
            "truth_pairs.csv:2: no such frame or body",
        ),
        (
            "truth_pairs.csv",
            "frame,a,b\n0,0,3\n",
            "truth_pairs.csv:2: no such frame or body",
        ),
    ];
    for (file, content, message) in cases {
        let folder = recording();
        folder.write(file, content);
        let answer = folder.run("scene .");
        assert_eq!(answer.status, 2, "{file}: {content}");
        assert!(answer.err.contains(message), "{} {message}", answer.err);
    }
    assert_eq!(recording().run("scene . --threads 2 --clock cpu").status, 2);
    assert_eq!(
        recording()
            .run("scene . --budget-us 5 --budget-work 5")
            .status,
        2
    );
}

#[test]
fn a_file_of_the_calls_of_a_scene_is_played_up_to_its_first_fault() {
    let folder = Folder::new();
    let ball = Arc::new(Tree::new(icosphere(2)));
    let file = File::create(folder.path().join("odd.jsonl")).unwrap();
    let mut scene = Scene::recorded(BufWriter::new(file));
    let at = |x: f64| Pose::from_quat([0.0, 0.0, 0.0, 1.0], [x, 0.1, 0.0]).unwrap();
    let fixed = scene
        .insert(Body::fixed(Arc::clone(&ball), at(0.0)))
        .unwrap();
    scene.find_contacts();
    let mut rows = Vec::new();
    for frame in 0..FRAMES {
        let x = 3.0 - 0.5 * frame as f64;
        let new = scene
            .insert(Body::moving(Arc::clone(&ball), at(x)))
            .unwrap();
        scene.measure(fixed, new, 0.1).unwrap();
        let report = scene.detect(Budget::work(3000));
        let [pairs, open] = [report.pairs.len() + report.unlisted, report.undecided()];
        let told = [
            frame,
            pairs,
            report.decided,
            report.intersecting,
            open + report.unlisted,
        ];
        let work = [report.bv_tests, report.work];
        rows.push(
            told.map(|count| count as u64)
                .into_iter()
                .chain(work)
                .collect::<Vec<_>>(),
        );
    }
    scene.stop_recording().unwrap();
    let played = |answer: &Answer| {
        let rows = rows_of_counts(&answer.out);
        assert!(rows.iter().any(|row| row[4] > 0), "a budget cuts it");
        rows
    };
    let text = folder.read("odd.jsonl");
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(text.as_bytes()).unwrap();
    folder.write("odd.jsonl.gz", packed.finish().unwrap());
    for file in ["odd.jsonl", "odd.jsonl.gz --threads 2"] {
        let answer = folder.ok(&format!("scene {file}"));
        assert_eq!(played(&answer), rows);
    }
    folder.write("cut.jsonl", &text[..text.len() - 10]);
    let answer = folder.run("scene cut.jsonl");
    assert_eq!(answer.status, 1);
    let lines = text.lines().count();
    assert!(
        answer.err.contains("cut.jsonl: ") && answer.err.contains(&format!("line {lines}")),
        "{}",
        answer.err
    );
    assert_eq!(played(&answer), rows[..FRAMES - 1]);
    let freely = folder.run("scene odd.jsonl --budget-work 1000000000 --answers told");
    assert!(rows_of_counts(&freely.out).iter().all(|row| row[4] == 0));
    let told = ["contacts", "distances"].map(|name| table(&folder, &format!("told/{name}.csv")));
    // Every distance, in every frame.
    assert_eq!(told[1].len(), FRAMES * (FRAMES + 1) / 2);
    assert!(!told[0].is_empty());
    folder.write("mesh.obj", "v 1 2 3\n");
    folder.refused("scene mesh.obj", &["mesh.obj: ", "line 1"]);
    folder.refused("scene odd.jsonl --mode all", &["its own mode"]);
}

/// The rows without their times.
fn rows_of_counts(output: &str) -> Vec<Vec<u64>> {
    let rows = rows(output);
    rows.iter()
        .map(|row| [&row[..5], &row[8..]].concat())
        .collect()
}
