//! `--view`: the pages hold what the answers say, within their limits of size, and refer to nothing.

use std::io::Read;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::read::ZlibDecoder;
use punctual::Mesh;
use punctual::glam::DVec3;
use punctual::shapes::{icosphere, torus};
use serde_json::Value;

use super::run::Folder;
use super::{spheres, write};

/// What a page holds.
pub struct Page {
    pub view: Value,
    words: Vec<u32>,
}

impl Page {
    pub fn read(folder: &Folder, name: &str) -> Self {
        let html = folder.read(name);
        assert!(
            !html.contains("http") && !html.contains("src=") && !html.contains("<!--"),
            "{name}"
        );
        let (_, rest) = html.split_once("id=\"data\">").unwrap();
        let packed = BASE64_STANDARD
            .decode(rest.split_once("</script>").unwrap().0)
            .unwrap();
        let mut bytes = Vec::new();
        ZlibDecoder::new(&*packed).read_to_end(&mut bytes).unwrap();
        let words: Vec<u32> = bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|word| u32::from_le_bytes(*word))
            .collect();
        let length = words[0] as usize;
        let view = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        Self {
            view,
            words: words[1 + length / 4..].to_vec(),
        }
    }

    pub fn range(&self, range: &Value) -> &[u32] {
        let [array, start, count] = [0, 1, 2].map(|i| range[i].as_u64().unwrap() as usize);
        let start = self.view["stage"]["starts"][array].as_u64().unwrap() as usize + start;
        &self.words[start..start + count]
    }

    fn floats(&self, range: &Value) -> Vec<f64> {
        self.range(range)
            .iter()
            .map(|&word| f64::from(f32::from_bits(word)))
            .collect()
    }

    pub fn steps(&self) -> &Vec<Value> {
        self.view["steps"].as_array().unwrap()
    }

    /// A line of the table at the step that is shown first.
    fn told(&self, name: &str) -> String {
        told(self.first(), name)
    }

    fn first(&self) -> &Value {
        &self.steps()[self.view["start"].as_u64().unwrap() as usize]
    }

    /// The numbers of a mesh are those of the file, but for where it lies and how large it is.
    pub fn assert_shows(&self, number: usize, mesh: &Mesh) {
        let shown = &self.view["stage"]["meshes"][number];
        assert_eq!(
            self.range(&shown["triangles"]),
            mesh.triangles().as_flattened()
        );
        let vertices = self.floats(&shown["vertices"]);
        let shown: Vec<DVec3> = vertices
            .as_chunks::<3>()
            .0
            .iter()
            .map(|&point| DVec3::from_array(point))
            .collect();
        assert_eq!(shown.len(), mesh.vertex_count());
        let scale = mesh.aabb().extents().length() / extent(&shown);
        let shift = mesh.vertex(0) - scale * shown[0];
        for (i, &point) in shown.iter().enumerate() {
            assert!(
                (scale * point + shift - mesh.vertex(i)).length() < 1e-6 * scale,
                "vertex {i}"
            );
        }
    }
}

fn extent(points: &[DVec3]) -> f64 {
    let least = points
        .iter()
        .fold(DVec3::INFINITY, |least, &p| least.min(p));
    (points
        .iter()
        .fold(DVec3::NEG_INFINITY, |most, &p| most.max(p))
        - least)
        .length()
}

fn told(step: &Value, name: &str) -> String {
    let lines = step["facts"].as_array().unwrap();
    let line = lines
        .iter()
        .find(|line| line[0] == name)
        .unwrap_or_else(|| panic!("no {name}: {lines:?}"));
    line[1].as_str().unwrap().replace(',', "")
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("no number: {text}"))
}

/// What is said of a line of the table.
fn remark<'s>(step: &'s Value, name: &str) -> Option<&'s str> {
    step["remarks"]
        .as_array()
        .unwrap()
        .iter()
        .find(|line| line[0] == name)
        .map(|line| line[1].as_str().unwrap())
}

#[test]
fn a_distance_stopped_before_anything_is_found_shows_what_is_open() {
    let (folder, _) = spheres();
    folder.run("distance a.obj b.obj poses.txt --budget-work 1 --view page.html --view-pose 4");
    let page = Page::read(&folder, "page.html");
    let first = &page.steps()[0];
    assert_eq!(
        ["Proven: at most", "Likely, 80 of 100"].map(|name| told(first, name)),
        ["not bounded", "not known yet"]
    );
    assert!(number(&told(first, "Open boxes")) > 0.0);
    assert_eq!(
        remark(first, "Open boxes"),
        Some("anywhere: nothing bounds them yet")
    );
    // Drawn once, around all that is shown.
    let bounds: Vec<f64> = page.view["stage"]["bounds"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(numbers)
        .collect();
    assert_eq!(page.floats(&first["boxes"]), bounds);
    // Once there is an upper bound, boxes are no larger than what they bound, and in the end there are none.
    for step in page.steps() {
        for open in page.floats(&step["boxes"]).as_chunks::<6>().0 {
            assert!(
                (0..6).all(|i| if i < 3 {
                    open[i] >= bounds[i]
                } else {
                    open[i] <= bounds[i]
                }),
                "{open:?}"
            );
        }
    }
    let last = page.steps().last().unwrap();
    assert_eq!(
        (told(last, "Open boxes"), remark(last, "Open boxes")),
        ("0".into(), None)
    );
}

fn numbers(list: &Value) -> impl Iterator<Item = f64> {
    list.as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
}

#[test]
fn a_bound_far_from_what_was_found_is_marked() {
    let (folder, _) = spheres();
    folder.run("pair a.obj b.obj poses.txt --mode all --view page.html --view-pose 1");
    let page = Page::read(&folder, "page.html");
    let mut marked = 0;
    for step in page.steps() {
        let found = number(&told(step, "Pairs found")).max(1.0);
        let name = "Pairs, at most";
        let says_nothing = number(&told(step, name)) > 100.0 * found;
        assert_eq!(
            remark(step, name),
            says_nothing.then_some("says nothing yet"),
            "{step}"
        );
        marked += usize::from(says_nothing);
    }
    assert!(marked > 0 && marked < page.steps().len());
    assert_eq!(
        told(&page.steps()[0], "Share found, expected"),
        "none found yet"
    );
}

#[test]
fn up_is_guessed_and_the_ground_lies_below_all() {
    let folder = Folder::new();
    folder.write("ball.obj", write::obj(&icosphere(1)));
    folder.write("ring.obj", write::obj(&torus(1.0, 0.1, 16)));
    folder.write("poses.txt", "1 0 0 3 0 1 0 0 0 0 1 0\n");
    for (a, up, why) in [
        ("ball", 2, "nothing says otherwise"),
        ("ring", 2, "it is flat across that"),
    ] {
        folder.run(&format!("pair {a}.obj ball.obj poses.txt --view page.html"));
        let page = Page::read(&folder, "page.html");
        assert_eq!(
            (&page.view["up"][0], &page.view["up"][1]),
            (&up.into(), &why.into())
        );
        for axis in 0..3 {
            let low = page.view["stage"]["bounds"][0][axis].as_f64().unwrap();
            let [side, lines] = [0, 1].map(|i| &page.view["stage"]["grids"][axis][i]);
            let ground = page.floats(lines);
            assert!(["0.2", "0.5", "1"].contains(&side.as_str().unwrap()) && ground.len() >= 6 * 6);
            assert!(
                ground
                    .iter()
                    .skip(axis)
                    .step_by(3)
                    .all(|&height| height < low && height > low - 0.02)
            );
        }
    }
}

#[test]
fn a_pair_is_shown_as_it_was_answered() {
    let (folder, truth) = spheres();
    let command = "pair a.obj b.obj poses.txt --mode all --pairs-out pairs.csv --view page.html --view-pose 1";
    assert_eq!(folder.run(command).rows()[1].pairs as u64, truth[1]);
    let page = Page::read(&folder, "page.html");
    page.assert_shows(0, &icosphere(2));
    page.assert_shows(1, &icosphere(1));

    let steps = page.steps();
    assert!(steps.len() > 10 && page.view["start"] == steps.len() - 1);
    let found: Vec<f64> = steps
        .iter()
        .map(|step| number(&told(step, "Pairs found")))
        .collect();
    let most: Vec<f64> = steps
        .iter()
        .map(|step| number(&told(step, "Pairs, at most")))
        .collect();
    assert!(found.is_sorted() && most.is_sorted_by(|a, b| a >= b));
    assert_eq!(
        (found[0], *found.last().unwrap(), *most.last().unwrap()),
        (0.0, truth[1] as f64, truth[1] as f64)
    );
    assert_eq!(
        (told(&steps[0], "Open boxes"), page.told("Open boxes")),
        ("1".into(), "0".into())
    );

    // The triangles that meet, by their corners.
    let lines = folder.read("pairs.csv");
    let listed = lines.lines().map(|line| {
        line.split(',')
            .map(|n| n.parse().unwrap())
            .collect::<Vec<usize>>()
    });
    let mut listed: Vec<usize> = listed
        .filter(|line| line[0] == 1)
        .map(|line| line[1])
        .collect();
    listed.sort_unstable();
    listed.dedup();
    let met = page
        .range(&steps.last().unwrap()["surfaces"][2][3])
        .as_chunks::<3>()
        .0;
    let mesh = icosphere(2);
    let mut shown: Vec<_> = met
        .iter()
        .map(|corners| mesh.triangles().iter().position(|t| t == corners))
        .collect();
    shown.sort_unstable();
    assert_eq!(shown, listed.into_iter().map(Some).collect::<Vec<_>>());
}

#[test]
fn a_stopped_answer_is_the_step_that_is_shown_first() {
    let (folder, _) = spheres();
    let command =
        "pair a.obj b.obj poses.txt --mode all --budget-work 2000 --view page.html --view-pose 1";
    let row = &folder.run(command).rows()[1];
    assert_eq!(row.stop, "work-limit");
    let page = Page::read(&folder, "page.html");
    let told = ["Pairs found", "Pairs, at most"].map(|name| number(&page.told(name)));
    assert_eq!(told, [row.pairs as f64, row.upper_bound as f64]);
    let name = page.first()["name"].as_str().unwrap().replace(',', "");
    assert!(name.starts_with(&format!("{} units ", row.work)), "{name}");
    assert!(number(&page.told("Open boxes")) > 0.0);
}

#[test]
fn distances_contacts_and_motions_are_shown() {
    let (folder, _) = spheres();
    let fields = |out: &str, line: usize| -> Vec<String> {
        out.lines()
            .nth(line + 2)
            .unwrap()
            .split(',')
            .map(str::to_owned)
            .collect()
    };
    let answer = folder
        .run("distance a.obj b.obj poses.txt --budget-work 1000 --view page.html --view-pose 4");
    let row = fields(&answer.out, 4);
    let page = Page::read(&folder, "page.html");
    for (name, column) in [("Proven: at least", 1), ("Proven: at most", 2)] {
        let (told, said) = (page.told(name), &row[column]);
        let unbounded = told == "not bounded" && said == "inf";
        assert!(
            unbounded || (number(&told) - number(said)).abs() < 1e-4,
            "{name}: {told}, {row:?}"
        );
    }
    let bounds = |name: &str| {
        page.steps()
            .iter()
            .map(|step| told(step, name))
            .collect::<Vec<_>>()
    };
    assert_eq!(bounds("Proven: at most")[0], "not bounded");
    assert_eq!(
        bounds("Proven: at least").last(),
        bounds("Proven: at most").last()
    );

    let answer =
        folder.run("contacts a.obj b.obj poses.txt --margin 0.1 --view page.html --view-pose 2");
    let contacts = answer
        .out
        .lines()
        .filter(|line| line.starts_with("2,contact,"))
        .count();
    let page = Page::read(&folder, "page.html");
    assert_eq!(number(&page.told("Contacts found")), contacts as f64);
    let lines = &page.steps().last().unwrap()["lines"];
    assert!(
        contacts > 0
            && [0, 1]
                .iter()
                .all(|&i| page.range(&lines[i][1]).len() == 6 * contacts)
    );

    let solids =
        "contacts a.obj b.obj poses.txt --margin 0.1 --solid --view page.html --view-pose 2";
    let answer = folder.run(solids);
    let overlaps = answer
        .out
        .lines()
        .filter(|line| line.starts_with("2,overlap,"));
    let overlaps = overlaps.count();
    let page = Page::read(&folder, "page.html");
    let lines = &page.steps().last().unwrap()["lines"];
    assert!(overlaps > 0 && lines[2][0] == "near");
    for (line, count) in [(0, contacts + overlaps), (1, contacts), (2, overlaps)] {
        assert_eq!(page.range(&lines[line][1]).len(), 6 * count, "{line}");
    }
    let surfaces = &page.steps().last().unwrap()["surfaces"];
    let size = |i: usize| page.range(&surfaces[i][3]).len();
    assert!((2..4).all(|i| surfaces[i][0] == "sunk" && size(i) < size(i - 2)));
    assert!(size(2) + size(3) > 0);

    folder.write("sweeps.txt", "1 0 0 -4 0 1 0 0 0 0 1 0 4 0 0\n");
    let answer = folder.run("motion a.obj b.obj sweeps.txt --view page.html");
    let row = fields(&answer.out, 0);
    let page = Page::read(&folder, "page.html");
    for (name, column) in [("Proven free until", 1), ("Proven to touch at", 2)] {
        assert!(
            (number(&page.told(name)) - number(&row[column])).abs() < 1e-6,
            "{name}: {row:?}"
        );
    }
    let open: Vec<f64> = page
        .steps()
        .iter()
        .map(|step| number(&told(step, "Open boxes")))
        .collect();
    assert!(
        open[0] == 1.0 && *open.last().unwrap() == 0.0 && open.iter().any(|&open| open > 1.0),
        "{open:?}"
    );
    let marks = &page.steps().last().unwrap()["marks"];
    assert_eq!(
        [0, 1, 2].map(|i| marks[i][0].as_str().unwrap()),
        ["start", "free until", "touching at"]
    );
    assert_eq!(page.view["times"].as_array().unwrap().len(), 129);
}

#[test]
fn pages_keep_their_limits_of_size() {
    for (parts, triangles, limit) in [(64, 4_000, 1_000_000), (264, 69_000, 6_000_000)] {
        let folder = Folder::new();
        let mesh = torus(1.0, 0.4, parts);
        assert!(mesh.len() >= triangles, "{}", mesh.len());
        folder.write("a.obj", write::obj(&mesh));
        folder.write("poses.txt", "0 -1 0 0.9 1 0 0 0.05 0 0 1 0.02\n");
        assert_eq!(
            folder
                .run("pair a.obj a.obj poses.txt --mode all --view page.html")
                .status,
            0
        );
        let bytes = folder.bytes("page.html").len();
        assert!(bytes < limit, "{triangles} triangles each: {bytes} bytes");
        Page::read(&folder, "page.html").assert_shows(1, &mesh);
    }
}

#[test]
fn views_that_cannot_be_made_are_refused() {
    let (folder, _) = spheres();
    let pair = "pair a.obj b.obj poses.txt";
    folder.refused(&format!("{pair} --view-pose 1"), &["--view"]);
    for (rest, words) in [
        ("x.html --view-pose 5", "--view-pose 5"),
        ("no/x.html", "no/x.html"),
    ] {
        let answer = folder.run(&format!("{pair} --view {rest}"));
        // What was asked for besides is answered.
        assert_eq!((answer.status, answer.rows().len()), (2, 5));
        answer.tells(words);
    }
    folder.write("bad.txt", "no pose\n");
    let answer = folder.run("distance a.obj b.obj bad.txt --view x.html");
    assert!(
        answer.status == 2 && answer.err.contains("--view-pose 0"),
        "{}",
        answer.err
    );
}
