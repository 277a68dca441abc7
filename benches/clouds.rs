//! Point clouds and the links of a robot: `cargo bench -p punctual-benches --bench clouds -- ROBOT [POINTS [TIMES [QUESTION REPEATS]]]` (default 100,000, 0).
//!
//! ROBOT is a folder with `robot.urdf`, `shapes.csv`, `configs.csv` and `environment.csv`, as the robots of the shared data. The
//! cloud is a sample of the surfaces of the environment with a noise of 2 mm. Of each of 100 configurations it is asked whether
//! a point is within 2 cm of the links that are meshes, their triangles divided in four TIMES times, how far the nearest is, and which are within 2 cm;
//! also of a window of the same points. Printed is CPU time
//! of a configuration in microseconds: median, mean and 95 %.

use std::collections::HashMap;
use std::path::Path;

use cpu_time::ThreadTime;
use oorandom::Rand64;
use punctual::tree::PointWindow;
use punctual::{Answer, Budget, Mesh, Pose, Query, Tree, Workspace};
use punctual_robot::{Model, UrdfOptions};

const WITHIN: f64 = 0.02;

/// The rows of a file of commas, without its heading.
fn rows(file: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(file).expect("a file of the robot");
    let row = |line: &str| line.split(',').map(String::from).collect();
    text.lines().skip(1).map(row).collect()
}

fn load(file: &Path) -> Mesh {
    punctual_io::load(file).expect("a mesh").mesh
}

/// Points of the surfaces, as many of each as its share of the area.
fn sample(meshes: &[Mesh], count: usize) -> Vec<[f32; 3]> {
    let mut random = Rand64::new(7);
    let (mut ends, mut sum) = (Vec::new(), 0.0);
    let corners: Vec<_> = meshes
        .iter()
        .flat_map(|mesh| (0..mesh.len()).map(|i| mesh.triangle(i)))
        .collect();
    for [a, b, c] in &corners {
        sum += (*b - *a).cross(*c - *a).length();
        ends.push(sum);
    }
    let mut point = || {
        let at = random.rand_float() * sum;
        let [a, b, c] = corners[ends.partition_point(|end| *end < at).min(ends.len() - 1)];
        let (mut s, mut t) = (random.rand_float(), random.rand_float());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        let place = (a + (b - a) * s + (c - a) * t).to_array();
        place.map(|x| (x + 2e-3 * (random.rand_float() - 0.5)) as f32)
    };
    (0..count).map(|_| point()).collect()
}

/// Median, mean and 95 %, in microseconds.
fn told(times: &[f64]) -> String {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
    format!("{:>9.1} {mean:>9.1} {:>9.1}", at(0.5), at(0.95))
}

/// Least CPU time of some calls, in milliseconds.
fn least<R>(calls: usize, mut call: impl FnMut() -> R) -> f64 {
    let time = |_| {
        let start = ThreadTime::now();
        std::hint::black_box(call());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..calls).map(time).fold(f64::INFINITY, f64::min)
}

/// Each triangle divided in four.
fn divided(mesh: &Mesh) -> Mesh {
    let four = (0..mesh.len()).flat_map(|i| {
        let [a, b, c] = mesh.triangle(i);
        let [d, e, f] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
        [a, d, f, d, b, e, f, e, c, d, e, f].map(|v| v.as_vec3().to_array())
    });
    let vertices: Vec<_> = four.collect();
    let corners = (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh::new(vertices.iter().copied(), corners).unwrap()
}

struct Links {
    trees: Vec<Tree>,
    /// Of each configuration, the pose of each link.
    poses: Vec<Vec<Pose>>,
}

fn links(folder: &Path, times: usize) -> Links {
    let model = Model::from_urdf(folder.join("robot.urdf"), &UrdfOptions::default()).unwrap();
    let index: HashMap<_, _> = model.link_names().zip(0..).collect();
    let (mut trees, mut of_link) = (Vec::new(), Vec::new());
    for row in rows(&folder.join("shapes.csv")) {
        if row[3] == "mesh" && row[1] != "world" && index[row[1].as_str()] > 0 {
            let mesh = load(&folder.join(&row[7]));
            trees.push(Tree::new((0..times).fold(mesh, |mesh, _| divided(&mesh))));
            of_link.push(index[row[1].as_str()]);
        }
    }
    let configurations = rows(&folder.join("configs.csv"));
    let poses = configurations.iter().take(100).map(|row| {
        let values: Vec<f64> = row.iter().map(|x| x.parse().unwrap()).collect();
        let all = model.link_poses(&values).unwrap();
        of_link.iter().map(|&link| all[link]).collect()
    });
    let poses = poses.collect();
    Links { trees, poses }
}

/// A cloud, and what its questions need.
struct Asker<'t> {
    cloud: &'t Tree,
    workspace: Workspace,
    /// The link by which a point was last seen.
    seen: Vec<usize>,
    /// Box tests, tests of triangles or points, and units of work.
    counts: [u64; 3],
}

impl Asker<'_> {
    fn count<T>(&mut self, answer: Answer<T>) -> T {
        let stats = &answer.stats;
        let counts = [stats.bv_tests, stats.primitive_tests, stats.work];
        for (sum, count) in self.counts.iter_mut().zip(counts) {
            *sum += count;
        }
        answer.value
    }

    fn any(&mut self, links: &[(&Tree, Pose)]) -> f64 {
        let is_near = |(link, pose): &(&Tree, Pose)| {
            let query = Query::distance(self.cloud, link, *pose).closer_than(WITHIN);
            let answer = query.run(&mut self.workspace, Budget::unlimited());
            self.count(answer).closer == Some(true)
        };
        f64::from(links.iter().any(is_near))
    }

    fn nearest(&mut self, links: &[(&Tree, Pose)]) -> f64 {
        links.iter().fold(f64::INFINITY, |low, (link, pose)| {
            let query = Query::distance(self.cloud, link, *pose).below(low);
            let answer = query.run(&mut self.workspace, Budget::unlimited());
            low.min(self.count(answer).high)
        })
    }

    fn all(&mut self, links: &[(&Tree, Pose)]) -> f64 {
        let near = |(link, pose): &(&Tree, Pose)| {
            let query = Query::points_within(self.cloud, link, *pose, WITHIN).unwrap();
            let answer = query.run(&mut self.workspace, Budget::unlimited());
            self.count(answer)
        };
        links.iter().map(near).sum::<u64>() as f64
    }

    /// The simplest way before: contacts, and a set of the points seen.
    fn contacts(&mut self, links: &[(&Tree, Pose)]) -> f64 {
        self.seen.fill(usize::MAX);
        let mut found = 0;
        for (i, (link, pose)) in links.iter().enumerate() {
            let query = Query::contacts(self.cloud, link, *pose).margin(WITHIN);
            let mut answer = Ok(query.run(&mut self.workspace, Budget::unlimited()));
            while answer.is_ok() {
                for contact in self.workspace.drain_contacts() {
                    let point = &mut self.seen[contact.triangles[0] as usize];
                    found += u32::from(*point != i);
                    *point = i;
                }
                answer = query.resume(&mut self.workspace, Budget::unlimited());
            }
        }
        f64::from(found)
    }
}

type Question<'t> = fn(&mut Asker<'t>, &[(&Tree, Pose)]) -> f64;

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|x| !x.starts_with("--"));
    let folder = arguments.next().expect("the folder of a robot");
    let folder = Path::new(&folder);
    let count = arguments.next().map_or(100_000, |x| x.parse().unwrap());
    let times = arguments.next().map_or(0, |x| x.parse().unwrap());
    let Links { trees, poses } = links(folder, times);
    let environment = rows(&folder.join("environment.csv"));
    let mesh = |row: &Vec<String>| load(&folder.join(&row[1]));
    let points = sample(&environment.iter().map(mesh).collect::<Vec<_>>(), count);
    let build = least(9, || Tree::from_points(points.iter().copied()).unwrap());
    let cloud = Tree::from_points(points.iter().copied()).unwrap();
    let mesh = Mesh::from_points(points.iter().copied()).unwrap();
    let normally = least(5, || Tree::new(mesh.clone()));
    let normal = Tree::new(mesh);
    let corners = (0..count as u32).map(|i| [i; 3]);
    let degenerate = Tree::new(Mesh::new(points.iter().copied(), corners).unwrap());
    println!(
        "{} links, {} triangles; {count} points, {} bytes each, built in {build:.2}, normally {normally:.2} ms",
        trees.len(),
        trees.iter().map(|tree| tree.mesh().len()).sum::<usize>(),
        cloud.stats().bytes() / count
    );
    let mut window = PointWindow::new(count, 5.0).unwrap();
    window.insert(&points).unwrap();
    let frame = &points[..count.min(10_000)];
    let of_frame = least(9, || {
        window.insert(frame).unwrap();
        window.advance(Budget::unlimited())
    });
    println!(
        "a window of all points takes a frame of {} in {of_frame:.2} ms",
        frame.len()
    );
    window.insert(&points).unwrap();
    window.advance(Budget::unlimited());
    let asker = |cloud| {
        let mut workspace = Workspace::new();
        workspace.reserve_near_points(count);
        workspace.reserve_contacts(1 << 16);
        let seen = vec![0; count];
        Asker {
            cloud,
            workspace,
            seen,
            counts: [0; 3],
        }
    };
    let questions: [(&str, &Tree, Question); 12] = [
        ("any", &cloud, Asker::any),
        ("any, window", window.tree(), Asker::any),
        ("any, normal", &normal, Asker::any),
        ("any, triangles", &degenerate, Asker::any),
        ("nearest", &cloud, Asker::nearest),
        ("nearest, window", window.tree(), Asker::nearest),
        ("nearest, normal", &normal, Asker::nearest),
        ("nearest, triangles", &degenerate, Asker::nearest),
        ("all", &cloud, Asker::all),
        ("all, window", window.tree(), Asker::all),
        ("all, normal", &normal, Asker::all),
        ("all, by contacts", &cloud, Asker::contacts),
    ];
    let only = arguments.next();
    let repeats = arguments.next().map_or(1, |x| x.parse().unwrap());
    let is_asked = |name: &str| only.as_ref().is_none_or(|only| only == name);
    let mut askers = questions.map(|(_, cloud, _)| asker(cloud));
    let (mut times, mut sums) = ([const { Vec::new() }; 12], [0.0; 12]);
    for poses in (0..repeats).flat_map(|_| &poses) {
        let links: Vec<_> = trees.iter().zip(poses.iter().copied()).collect();
        for (i, (name, _, ask)) in questions.iter().enumerate() {
            if !is_asked(name) {
                continue;
            }
            let start = ThreadTime::now();
            sums[i] += ask(&mut askers[i], &links);
            times[i].push(start.elapsed().as_secs_f64() * 1e6);
        }
    }
    println!(
        "{:<20} {:>9} {:>9} {:>9}  [box tests, others, work]  sum",
        "us", "median", "mean", "95 %"
    );
    for (i, (name, ..)) in questions.iter().enumerate() {
        if !is_asked(name) {
            continue;
        }
        let counts = askers[i].counts.map(|count| count / times[i].len() as u64);
        println!("{name:<20} {}  {counts:?}  {:.6}", told(&times[i]), sums[i]);
    }
}
