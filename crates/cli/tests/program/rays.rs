//! `punctual rays` from outside: its columns, its messages, hits that are known.

use punctual::shapes::cuboid;

use crate::run::Folder;
use crate::write;

const HEADER: &str = "ray,triangle,t,side,free_until,ns,stop,work";

fn cube() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", write::obj(&cuboid([1.0; 3], 2)));
    let lines = [
        "-3 .3 .4 2 0 0 # through",
        "-3 .3 .4 -2 0 0",
        "1 2 3 0 0 0",
        "0 .3 .4 1 0 0",
        "-3 1 .4 1 0 0",
    ];
    folder.write("rays.txt", lines.join("\n"));
    folder
}

/// What the lines say but for the triangle, the time and the work.
fn said(folder: &Folder, options: &str) -> Vec<String> {
    let answer = folder.run(&format!("rays a.obj rays.txt {options}"));
    assert_eq!(answer.status, 1, "{options}: {}", answer.err);
    assert!(
        answer
            .err
            .contains("rays.txt:3: ray 2: the ray's direction is zero"),
        "{}",
        answer.err
    );
    let lines = answer.lines(HEADER);
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        assert!(
            fields.len() == 8
                && fields[5].parse::<u64>().is_ok()
                && fields[7].parse::<u64>().is_ok(),
            "{line}"
        );
        assert_eq!(fields[1].parse::<u32>().is_ok(), !fields[2].is_empty());
        [0, 2, 3, 4, 6].map(|i: usize| fields[i]).join(",")
    };
    lines.map(row).collect()
}

#[test]
fn rays_of_a_solid_say_whether_they_start_inside() {
    let answer = cube().run("rays a.obj rays.txt --solid");
    let lines = answer.lines(&format!("{HEADER},inside"));
    let said: Vec<&str> = lines.map(|line| line.rsplit(',').next().unwrap()).collect();
    assert_eq!(said, ["no", "no", "", "yes", "no"]);
}

#[test]
fn hits_of_a_cube() {
    let folder = cube();
    let nearest = [
        "0,1,front,1,finished",
        "1,,,inf,finished",
        "2,,,,error",
        "3,1,back,1,finished",
        "4,2,edge,2,finished",
    ];
    for options in ["", "--mode nearest --reps 2", "--portable"] {
        let rows = said(&folder, options);
        assert_eq!(rows[..4], nearest[..4], "{options}");
        // Where the ray comes into the plane of a face it also meets the face before.
        assert!(
            rows[4].starts_with("4,2,") && rows[4].ends_with(",2,finished"),
            "{}",
            rows[4]
        );
    }
    let all = said(&folder, "--mode all");
    assert_eq!(
        all[..2],
        ["0,1,front,inf,finished", "0,2,back,inf,finished"]
    );
    assert!(all.len() > 8, "{all:?}");
    assert_eq!(said(&folder, "--mode any")[3], "3,1,back,0,first-hit");
    let stopped = said(&folder, "--budget-work 0");
    assert!(
        stopped
            .iter()
            .all(|row| row.ends_with(",,,0,work-limit") || row == "2,,,,error"),
        "{stopped:?}"
    );
}

#[test]
fn segments_end_at_their_ends() {
    let folder = cube();
    folder.write(
        "rays.txt",
        "-3 .3 .4 -1 .3 .4\n-3 .3 .4 -1.001 .3 .4\n-3 .3 .4 -3 .3 .4\n",
    );
    let answer = folder.run("rays a.obj rays.txt --segments");
    assert!(
        answer.status == 1 && answer.err.contains("rays.txt:3: ray 2: "),
        "{}",
        answer.err
    );
    let lines: Vec<&str> = answer.lines(HEADER).collect();
    assert!(
        lines[0].contains(",1,front,1,") && lines[1].starts_with("1,,,,inf,") && lines.len() == 3,
        "{lines:?}"
    );
}

#[test]
fn bad_options_are_refused_and_all_are_named() {
    let folder = cube();
    let options = "--segments --mode --reps --budget-us --budget-work --portable";
    folder.help_names("rays", options);
    folder.refuses(
        "rays a.obj",
        &[
            ("rays.txt --mode first", "--mode first"),
            ("none.txt", "none.txt:"),
        ],
    );
}
