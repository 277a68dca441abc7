//! `punctual robot` from outside: its columns, its messages, answers that are known.

use punctual::shapes::cuboid;

use crate::run::{Answer, Folder};
use crate::view::Page;
use crate::write;

/// A slide along x that carries a cube of edge 2 towards a wall, whose face is at x = 5.
fn slide() -> Folder {
    let folder = Folder::new();
    let shape = "<collision><geometry><box size=\"2 2 2\"/></geometry></collision>";
    folder.write(
        "robot.urdf",
        format!(
            "<robot name=\"slide\"><link name=\"rail\"/><link name=\"cube\">{shape}</link>\n\
             <joint name=\"x\" type=\"prismatic\"><parent link=\"rail\"/><child link=\"cube\"/>\n\
             <limit lower=\"-9\" upper=\"9\"/></joint></robot>"
        ),
    );
    folder.write(
        "allowed.srdf",
        "<robot><disable_collisions link1=\"rail\" link2=\"none\"/></robot>",
    );
    std::fs::create_dir(folder.path().join("env")).unwrap();
    let mesh = cuboid([1.0, 3.0, 3.0], 2);
    let moved = (0..mesh.vertex_count())
        .map(|i| (mesh.vertex(i) + 6.0 * punctual::glam::DVec3::X).to_array());
    let mesh = punctual::Mesh::from_f64(moved, mesh.triangles().iter().copied()).unwrap();
    folder.write("env/wall.obj", write::obj(&mesh));
    folder.write("env/notes.txt", "not a mesh");
    folder.write("configs.csv", "other,x\n7,0\n7,4.5\n7,oops\n7,3.75\n");
    folder.write("edges.csv", "edge,from_x,to_x\n0,-3,3\n1,0,8\n2,0\n");
    folder
}

fn fields(answer: &Answer, header: &str) -> Vec<Vec<String>> {
    let row = |line: &str| line.split(',').map(str::to_owned).collect();
    answer.lines(header).map(row).collect()
}

#[test]
fn labels_name_the_pair() {
    let folder = slide();
    for options in ["", "--threads 2", "--reps 2", "--budget-work 100000"] {
        let answer = folder.run(&format!(
            "robot robot.urdf --env env --configs configs.csv {options}"
        ));
        assert_eq!(answer.status, 1);
        assert!(
            answer
                .err
                .contains("configs.csv:4: configuration 2: x is \"oops\""),
            "{}",
            answer.err
        );
        let rows = fields(&answer, "config,verdict,first_pair,ns,stop,work");
        let told: Vec<[&str; 4]> = rows
            .iter()
            .map(|r| [0, 1, 2, 4].map(|i| r[i].as_str()))
            .collect();
        let want = [
            ["0", "free", "", "finished"],
            ["1", "contact", "cube|wall", "finished"],
            ["2", "", "", "error"],
            ["3", "free", "", "finished"],
        ];
        assert_eq!(told, want, "{options}");
    }
    let none = folder.run("robot robot.urdf --env env --configs configs.csv --budget-work 0");
    assert!(none.out.contains("0,undecided,,") && none.out.contains(",work-limit,0\n"));
}

#[test]
fn clearance_is_bounded() {
    let folder = slide();
    let answer = folder.run("robot robot.urdf --env env --configs configs.csv --clearance");
    let rows = fields(&answer, "config,low,high,pair_a,pair_b,ns");
    for (row, want) in [(0, 4.0), (1, 0.0), (3, 0.25)] {
        let [low, high] = [1, 2].map(|i| rows[row][i].parse::<f64>().unwrap());
        assert!(
            low <= want && want <= high && high - low < 1.1e-9,
            "{:?}",
            rows[row]
        );
        assert_eq!(rows[row][3..5], ["cube", "wall"]);
    }
}

#[test]
fn a_margin_is_kept_and_told() {
    let folder = slide();
    let asked = "robot robot.urdf --env env --configs configs.csv --margin 0.5";
    let rows = fields(&folder.run(asked), "config,verdict,first_pair,ns,stop,work");
    let told = [0, 1, 3].map(|row| rows[row][1].as_str());
    assert_eq!(told, ["free", "contact", "contact"]);
    let answer = folder.run(&format!("{asked} --clearance"));
    let rows = fields(&answer, "config,low,high,pair_a,pair_b,ns");
    for (row, want) in [(0, 3.5), (1, -0.5), (3, -0.25)] {
        let [low, high] = [1, 2].map(|i| rows[row][i].parse::<f64>().unwrap());
        assert!(low <= want && want <= high && high - low < 1.1e-9);
    }
    let bad = folder.run(&asked.replace("0.5", "-1"));
    bad.tells("must be finite and not negative");
}

#[test]
fn edges_are_proven() {
    let folder = slide();
    for options in ["", "--first-contact", "--first-contact --threads 2"] {
        let answer = folder.run(&format!(
            "robot robot.urdf --env env --edges edges.csv {options}"
        ));
        assert_eq!(answer.status, 1);
        answer.tells("edges.csv:4: edge 2: no value of to_x");
        let rows = fields(
            &answer,
            "edge,answer,free_until,touching_at,pair_a,pair_b,ns,work",
        );
        assert_eq!(rows[0][..6], ["0", "free", "1", "", "", ""]);
        assert_eq!(
            (rows[1][1].as_str(), rows[2][1].as_str()),
            ("contact", "error")
        );
        let [free, at] = [2, 3].map(|i| rows[1][i].parse::<f64>().unwrap());
        assert!(
            free <= 0.5 && 0.5 <= at && rows[1][4..6] == ["cube", "wall"],
            "{:?}",
            rows[1]
        );
        assert!(options.is_empty() || at - free < 2e-6, "{:?}", rows[1]);
    }
}

#[test]
fn the_page_agrees_with_the_printed_lines() {
    let folder = slide();
    let command = "robot robot.urdf --env env --configs configs.csv --view page.html";
    assert_eq!(folder.run(command).status, 1);
    let page = Page::read(&folder, "page.html");
    let told = page.steps().iter().map(|step| {
        let layers = [0, 1].map(|i| step["surfaces"][i][0].as_str().unwrap());
        let met = page.range(&step["pairs"][0]).to_vec();
        (step["name"].as_str().unwrap(), layers, met)
    });
    let want = [
        ("0", ["a", "fixed"], vec![]),
        ("1", ["b", "b"], vec![0, 1]),
        ("3", ["mid", "fixed"], vec![]),
    ];
    assert_eq!(told.collect::<Vec<_>>(), want);
    assert_eq!(
        page.view["robot"]["ranges"][0].to_string(),
        "[\"x\",-9.0,9.0]"
    );
    let cut = folder.run(&format!("{command} --budget-work 0"));
    assert_eq!(cut.status, 1);
    let page = Page::read(&folder, "page.html");
    for step in page.steps() {
        assert_eq!(step["surfaces"][0][0], "doubt");
        assert_eq!(
            step["facts"][1].to_string(),
            "[\"Clearance, at most\",\"not bounded\"]"
        );
        assert_eq!(
            step["facts"][3].to_string(),
            "[\"Pairs that meet, at least\",\"0\"]"
        );
    }
    let edges = folder.run("robot robot.urdf --edges edges.csv --view page.html");
    assert_eq!(edges.status, 2, "{}", edges.err);
}

/// A package by the name in package.xml, a capsule of pinocchio's, and open meshes that were to be solids.
#[test]
fn ignored_parts_of_files_are_reported() {
    let folder = Folder::new();
    for path in ["pkg_folder/urdf", "pkg_folder/meshes", "env"] {
        std::fs::create_dir_all(folder.path().join(path)).unwrap();
    }
    folder.write(
        "pkg_folder/package.xml",
        "<package><name>arms</name></package>",
    );
    let open = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    folder.write("pkg_folder/meshes/flap.obj", open);
    folder.write("env/sheet.obj", open);
    let mesh = "<geometry><mesh filename=\"package://arms/meshes/flap.obj\"/></geometry>";
    let capsule = "<collision_checking><capsule name=\"flap\"/></collision_checking>";
    let link = format!("<link name=\"flap\"><collision>{mesh}</collision>\n{capsule}</link>");
    let joint = "<joint name=\"x\" type=\"continuous\"><parent link=\"base\"/><child link=\"flap\"/></joint>";
    let robot =
        format!("\n<?xml version=\"1.0\"?>\n<robot><link name=\"base\"/>{link}{joint}</robot>");
    folder.write("pkg_folder/urdf/r.urdf", robot);
    folder.write("q.csv", "x\n0\n");
    let command = "robot pkg_folder/urdf/r.urdf --configs q.csv --packages . --solids --env env";
    let answer = folder.run(command);
    assert_eq!(answer.status, 0, "{}", answer.err);
    for words in [
        "r.urdf:4: link flap: `collision_checking` in a `link` is passed over",
        "flap.obj: a surface, for it has 3 open edges",
        "sheet.obj: its open parts are surfaces, it has 3 open edges",
    ] {
        answer.tells(words);
    }
    answer.prints("0,contact,flap|sheet");
}

#[test]
fn what_is_wrong_is_named() {
    let folder = slide();
    let notice = folder.run("robot robot.urdf --srdf allowed.srdf --edges edges.csv");
    notice.tells("allowed.srdf:1: there is no link none");
    folder.write("bad.csv", "y\n1\n");
    folder.write("late.csv", "# joints\n\ny\n1\n");
    folder.write("twice.csv", "x,x\n1,2\n");
    folder.write("large.csv", "\u{feff}x\n0\n1e31\nnan\n1\n");
    std::fs::create_dir(folder.path().join("bare")).unwrap();
    let bare = folder.run("robot robot.urdf --env bare --configs large.csv");
    for words in [
        "bare: no mesh files",
        "large.csv:3: configuration 1: x is 1e31",
        "large.csv:4: configuration 2: x is nan",
    ] {
        bare.tells(words);
    }
    let stops = fields(&bare, "config,verdict,first_pair,ns,stop,work");
    let stops: Vec<&str> = stops.iter().map(|row| row[4].as_str()).collect();
    assert_eq!(stops, ["finished", "error", "error", "finished"]);
    assert_eq!(bare.status, 1);
    for (options, words) in [
        ("robot none.urdf --configs configs.csv", "none.urdf"),
        (
            "robot robot.urdf --configs bad.csv",
            "bad.csv:1: no column x",
        ),
        (
            "robot robot.urdf --configs late.csv",
            "late.csv:3: no column x",
        ),
        (
            "robot robot.urdf --configs twice.csv",
            "twice.csv:1: two columns x",
        ),
        ("robot robot.urdf --configs none.csv", "none.csv"),
        ("robot robot.urdf --env none --configs configs.csv", "none"),
        ("robot robot.urdf", "--configs"),
    ] {
        let answer = folder.run(options);
        assert_eq!(answer.status, 2, "{options}");
        answer.tells(words);
    }
}
