//! Measures a robot in its cell: `measure DIR [labels|clearance|edges|horizon|balls|cloud|cycles
//! [REPETITIONS]]`, with the files of one robot: `robot.urdf`, `robot.srdf`, `env/`, `configs.csv`,
//! `labels.csv`, `clearance.csv`, `edges.csv`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use punctual::glam::DMat3;
use punctual::{Budget, BuildOptions, Mesh, Pose, Query, Tree, Workspace};
use punctual_geom::random::Random;
use punctual_robot::{
    Checker, ClearanceOptions, Collision, EdgeAnswer, EdgeOptions, Horizon, Margin, Model,
    NearPairs, RobotError, Shape, Track, Trajectory, UrdfOptions, braking_time, safe_speed,
};

type Table = Vec<Vec<String>>;

fn table(file: &Path) -> Result<Table, Box<dyn Error>> {
    let text = std::fs::read_to_string(file)?;
    let row = |line: &str| line.split(',').map(str::to_owned).collect();
    Ok(text.lines().skip(1).map(row).collect())
}

fn numbers(row: &[String]) -> Vec<f64> {
    row.iter().map(|x| x.parse().unwrap_or(f64::NAN)).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let dir = std::env::args().nth(1).ok_or("the folder of a robot")?;
    let dir = Path::new(&dir);
    let options = UrdfOptions::default().srdf(dir.join("robot.srdf"));
    let model = Arc::new(Model::from_urdf(dir.join("robot.urdf"), &options)?);
    let mut checker = Checker::new(Arc::clone(&model));
    let mut files: Vec<_> = std::fs::read_dir(dir.join("env"))?.collect::<Result<_, _>>()?;
    files.sort_by_key(|file| file.path());
    let mut obstacles = Vec::new();
    for file in files {
        let name = file
            .path()
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let mesh = punctual_io::load(&file.path())?.mesh;
        let shape = Shape::mesh(mesh);
        obstacles.push(shape.clone());
        checker.add(&name, Pose::IDENTITY, shape)?;
    }
    let pairs = table(&dir.join("pairs.csv"))?.len();
    println!("pairs {} of {pairs}", checker.pairs().len());
    let configs: Vec<Vec<f64>> = table(&dir.join("configs.csv"))?
        .iter()
        .map(|r| numbers(r))
        .collect();
    let labels: Vec<bool> = table(&dir.join("labels.csv"))?
        .iter()
        .map(|r| r[1] == "1")
        .collect();
    let unlimited = Budget::unlimited();
    let only = std::env::args().nth(2);
    let asks = |what: &str| only.as_deref().is_none_or(|only| only == what);
    let repetitions = std::env::args().nth(3);
    let repetitions = repetitions.and_then(|n| n.parse().ok()).unwrap_or(7);
    if asks("labels") {
        let mut wrong = 0;
        for (q, &meets) in configs.iter().zip(&labels) {
            let met = checker.collide(q, unlimited)?.value != Collision::Free;
            wrong += u32::from(met != meets);
        }
        println!("labels wrong {wrong} of {}", labels.len());
    }
    let ranges = if asks("labels") { 2 } else { 0 };
    let mut apart = checker.clone();
    apart.set_margin(Margin::All, 0.02)?;
    for (name, range) in [("random", 0..2000), ("near contact", 2000..2500)]
        .into_iter()
        .take(ranges)
    {
        let mut least = [f64::INFINITY; 2];
        for _ in 0..repetitions {
            for (checker, least) in [&mut checker, &mut apart].into_iter().zip(&mut least) {
                let start = ThreadTime::now();
                for q in &configs[range.clone()] {
                    let _ = checker.collide(q, unlimited)?;
                }
                *least = least.min(start.elapsed().as_secs_f64() * 1e6 / range.len() as f64);
            }
        }
        let [without, with] = least;
        println!("a label, {name}: {without:.2} us; with a margin of 2 cm: {with:.2} us");
    }
    let rows = table(&dir.join("clearance.csv"))?;
    for tolerance in [1e-9, 1e-4].into_iter().filter(|_| asks("clearance")) {
        let (mut off, mut widest, mut work) = (0f64, 0f64, 0);
        let options = ClearanceOptions::default().tolerance(tolerance);
        let start = ThreadTime::now();
        for row in rows.iter().map(|row| numbers(row)) {
            let found = checker.clearance(&configs[row[0] as usize], &options, unlimited)?;
            work += found.work;
            let found = found.value;
            off = off.max(found.low - row[2]).max(row[1] - found.high);
            widest = widest.max(found.high - found.low);
        }
        let us = start.elapsed().as_secs_f64() * 1e6 / rows.len() as f64;
        let work = work / rows.len() as u64;
        println!(
            "clearance to {tolerance:e}: {us:.1} us, work {work}, outside by {off:e}, widest {widest:e}"
        );
    }
    let rows = table(&dir.join("edges.csv"))?;
    let n = model.joint_names().len();
    let edges = [("any", EdgeOptions::any()), ("first", EdgeOptions::first())];
    for (name, options) in edges.into_iter().filter(|_| asks("edges")) {
        let (mut contradicted, mut undecided, mut free, mut work) = (0, 0, [0u32; 2], 0);
        let (mut late, mut times) = (0f64, [0.0; 2]);
        for row in rows.iter().cycle().take(rows.len() * repetitions) {
            let q = numbers(row);
            let start = ThreadTime::now();
            let edge = checker.edge(&q[1..=n], &q[n + 1..=2 * n], &options, unlimited)?;
            work += edge.work;
            let is_free = row[2 * n + 2] == "free";
            times[usize::from(is_free)] += start.elapsed().as_secs_f64() * 1e6;
            let edge = edge.value;
            let [low, high] = [q[2 * n + 3], q[2 * n + 4]];
            free[usize::from(is_free)] += 1;
            match edge.answer {
                EdgeAnswer::Free => contradicted += u32::from(!is_free),
                EdgeAnswer::Contact => contradicted += u32::from(is_free),
                EdgeAnswer::Undecided => undecided += 1,
            }
            let at = edge.touching_at.unwrap_or(1.0);
            contradicted += u32::from(edge.free_until > high || at < low);
            if options.first {
                late = late.max(at - edge.free_until);
            }
        }
        println!(
            "edges, {name}: {:.0} us; free {:.0}, blocked {:.0}; contradicted {contradicted}, undecided {undecided}, widest {late:e}, work {}",
            (times[0] + times[1]) / f64::from(free[0] + free[1]),
            times[1] / f64::from(free[1]),
            times[0] / f64::from(free[0]),
            work / u64::from(free[0] + free[1]),
        );
    }
    if asks("horizon") {
        horizon(&mut checker, &configs[..2000])?;
    }
    if asks("pairs") {
        near_pairs(&mut checker, &obstacles, &configs[..500])?;
    }
    if asks("balls") {
        balls(&checker, &configs[..2000])?;
    }
    if asks("cloud") {
        cloud(&checker, &configs[..1000])?;
    }
    if asks("cycles") {
        cycles(&checker, &configs[..2000])?;
    }
    Ok(())
}

/// 100,000 points on a table and walls about the robot, all replaced, then labels and edges.
fn cloud(checker: &Checker, configs: &[Vec<f64>]) -> Result<(), Box<dyn Error>> {
    let (mut checker, mut rng, unlimited) = (checker.clone(), Random::new(5), Budget::unlimited());
    let mut point = || {
        let [u, v] = [(); 2].map(|()| rng.between(-1.0, 1.0));
        let rough = rng.between(0.0, 0.004);
        match (rng.fraction() * 4.0) as u32 {
            0 => [0.9 + rough, u, 1.2 + v],
            1 => [u, 0.9 + rough, 1.2 + v],
            2 => [u, v, -0.05 - rough],
            _ => [0.55 + 0.1 * u, 0.3 * v, 0.3 + rough],
        }
    };
    let points: Vec<[f64; 3]> = (0..100_000).map(|_| point()).collect();
    let mut last = None;
    for options in [BuildOptions::fast_build(), BuildOptions::default()] {
        let mut replaced = f64::INFINITY;
        for _ in 0..7 {
            let start = ThreadTime::now();
            let mesh = Mesh::from_points_f64(points.iter().copied())?;
            let tree = Tree::with_options(mesh, &options).with_radius(0.005)?;
            let shape = Shape::tree(Arc::new(tree));
            if let Some(last) = last.take() {
                checker.remove(last)?;
            }
            last = Some(checker.add("cloud", Pose::IDENTITY, shape)?);
            let _ = checker.collide(&configs[0], unlimited)?;
            replaced = replaced.min(start.elapsed().as_secs_f64() * 1e3);
        }
        println!(
            "100,000 points, {:?}: replaced, with a label, in {replaced:.2} ms",
            options.effort
        );
        for margin in [0.0, 0.02] {
            checker.set_margin(Margin::Of("cloud"), margin)?;
            let (mut times, mut free) = (Vec::new(), 0);
            for q in configs {
                let start = ThreadTime::now();
                free += u32::from(checker.collide(q, unlimited)?.value == Collision::Free);
                times.push(start.elapsed().as_secs_f64() * 1e6);
            }
            let [median, mean, high] = spread(&mut times);
            println!(
                "a label, margin {margin}: {median:.2} / {mean:.2} / {high:.2} us, free {free}"
            );
            let mut edge = |q: &[Vec<f64>]| -> Result<f64, RobotError> {
                let start = ThreadTime::now();
                let edge = checker.edge(&q[0], &q[1], &EdgeOptions::any(), unlimited)?;
                assert_ne!(edge.value.answer, EdgeAnswer::Undecided);
                Ok(start.elapsed().as_secs_f64() * 1e6)
            };
            let mut times: Vec<f64> = configs
                .chunks_exact(2)
                .map(&mut edge)
                .collect::<Result<_, _>>()?;
            let [median, mean, high] = spread(&mut times);
            println!("an edge: {median:.1} / {mean:.1} / {high:.1} us");
            let near = |q: &Vec<f64>| q.iter().map(|x| x + 0.1).collect::<Vec<f64>>();
            let mut short = |q: &Vec<f64>| edge(&[q.clone(), near(q)]);
            let mut times: Vec<f64> = configs.iter().map(&mut short).collect::<Result<_, _>>()?;
            let [median, mean, high] = spread(&mut times);
            println!("an edge of .1 rad a joint: {median:.1} / {mean:.1} / {high:.1} us");
        }
    }
    Ok(())
}

/// Median, mean, and what 95 % are below.
fn spread(times: &mut [f64]) -> [f64; 3] {
    times.sort_unstable_by(f64::total_cmp);
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    [times[times.len() / 2], mean, times[times.len() * 95 / 100]]
}

/// 800 balls of 20 mm about the robot, added one by one, then labels among them.
fn balls(checker: &Checker, configs: &[Vec<f64>]) -> Result<(), Box<dyn Error>> {
    let (mut add, mut labels, mut first) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    let (ball, unlimited) = (Shape::sphere(0.02)?, Budget::unlimited());
    let mut free = 0;
    for _ in 0..7 {
        let (mut checker, mut rng) = (checker.clone(), Random::new(5));
        let _ = checker.collide(&configs[0], unlimited)?;
        let start = ThreadTime::now();
        for i in 0..800 {
            let at = [(); 3].map(|()| rng.between(-1.5, 1.5));
            checker.add(
                &format!("ball {i}"),
                Pose::new(DMat3::IDENTITY, at)?,
                ball.clone(),
            )?;
        }
        add = add.min(start.elapsed().as_secs_f64() * 1e3);
        let _ = checker.collide(&configs[0], unlimited)?;
        first = first.min(start.elapsed().as_secs_f64() * 1e3);
        for _ in 0..3 {
            let start = ThreadTime::now();
            free = 0;
            for q in configs {
                free += u32::from(checker.collide(q, unlimited)?.value == Collision::Free);
            }
            labels = labels.min(start.elapsed().as_secs_f64() * 1e6 / configs.len() as f64);
        }
    }
    println!("800 balls: added {add:.2} ms, with a label {first:.2} ms; a label {labels:.2} us");
    println!("free {free} of {}", configs.len());
    Ok(())
}

/// Moments at random configurations, on the way to others at up to 2 rad/s: how many are proven
/// free for 100 ms within 200 us, of those that are.
fn horizon(checker: &mut Checker, configs: &[Vec<f64>]) -> Result<(), Box<dyn Error>> {
    let (mut free, mut proven, mut times) = (0, 0, Vec::new());
    for (q, next) in configs.iter().zip(&configs[1..]) {
        let ways = q.iter().zip(next).map(|(a, b)| b - a);
        let fastest = ways.clone().fold(0f64, |most, way| most.max(way.abs()));
        let velocity: Vec<f64> = ways.map(|way| way * 2.0 / fastest).collect();
        let whole = checker.horizon(q, &velocity, 0.1, Budget::unlimited())?;
        if whole.value.free_until < 0.1 {
            continue;
        }
        free += 1;
        let start = Instant::now();
        let cut = checker.horizon(q, &velocity, 0.1, Budget::time(Duration::from_micros(200)))?;
        times.push(start.elapsed());
        proven += u32::from(cut.value.free_until == 0.1);
    }
    times.sort_unstable();
    let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
    println!(
        "horizon 100 ms within 200 us: proven {proven} of {free} free moments, median {:?}, 99 % {:?}, most {:?}",
        at(0.5),
        at(0.99),
        at(1.0)
    );
    Ok(())
}

/// A controller at 1 kHz with 200 us a cycle, on lines at up to 2 rad/s, with and without three
/// balls that cross the cell at 1 m/s: cycles in which it is proven for the balls of now that it
/// may go on, and those in which it must brake harder than it can. Against one that asks anew in
/// each cycle.
fn cycles(checker: &Checker, configs: &[Vec<f64>]) -> Result<(), Box<dyn Error>> {
    const CYCLE: f64 = 0.001;
    for (balls, budget) in [(0, 200), (0, 1_000_000), (3, 200), (3, 1_000_000)] {
        let mut checker = checker.clone();
        let mut places = Vec::new();
        for i in 0..balls {
            let turn = f64::from(i) * 2.1;
            let at = [0.9 * turn.cos(), 0.9 * turn.sin(), 0.3 + 0.2 * f64::from(i)];
            let pose = Pose::new(DMat3::IDENTITY, at)?;
            places.push((checker.add("ball", pose, Shape::sphere(0.08)?)?, at));
        }
        let (mut moved, mut proven, mut harder, mut cycles) = (0, 0, 0, 0);
        let (mut fresh_moved, mut fresh_harder, mut times) = (0, 0, Vec::new());
        let budget = Budget::time(Duration::from_micros(budget));
        for (q, next) in configs.iter().zip(&configs[1..]).step_by(20) {
            let ways = q.iter().zip(next).map(|(a, b)| b - a);
            let fastest = ways.clone().fold(0f64, |most, way| most.max(way.abs()));
            let velocity: Vec<f64> = ways.map(|way| way * 2.0 / fastest).collect();
            if checker.collide(q, Budget::unlimited())?.value != Collision::Free {
                continue;
            }
            let braking = braking_time(&velocity, &vec![10.0; q.len()]);
            let change = CYCLE / braking + 1e-9;
            let mut plan = Trajectory::default();
            plan.push(fastest / 2.0, &[q, &velocity])?;
            let mut horizon = Horizon::new(CYCLE, braking)?;
            let (mut speed, mut new) = (0.0, Some(&plan));
            let (mut at, mut fresh) = (0.0, 0.0);
            for cycle in 0..600 {
                let now = CYCLE * f64::from(cycle);
                for (id, [x, y, z]) in &places {
                    let velocity = [-x, -y, 0.0];
                    let at = [x - now * x, y - now * y, *z];
                    let track =
                        Track::velocity(&Pose::new(DMat3::IDENTITY, at)?, velocity, [0.0; 3]);
                    checker.move_along(*id, track?)?;
                }
                let start = Instant::now();
                let ahead = horizon.step(&mut checker, new.take(), budget)?.value;
                times.push(start.elapsed());
                let is_moving = speed > 0.0 || ahead.speed > 0.0;
                moved += u32::from(is_moving);
                proven += u32::from(is_moving && ahead.since == 0);
                harder += u32::from(ahead.speed < speed - change);
                cycles += 1;
                speed = ahead.speed;
                // Another one, that keeps nothing but its speed.
                let ahead = checker
                    .horizon(&plan.at(at), &velocity, braking, budget)?
                    .value;
                let allowed = safe_speed(ahead.free_until, CYCLE, braking);
                let is_harder = allowed < fresh - change && at < plan.seconds();
                fresh_moved += u32::from(fresh > 0.0);
                fresh_harder += u32::from(is_harder);
                fresh = allowed.min(fresh + change);
                at += fresh * CYCLE;
            }
        }
        times.sort_unstable();
        let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
        println!(
            "{balls} balls, {budget:?}: moved in {moved} of {cycles} cycles, proven anew in {proven}, braked too hard in {harder}; {:?} median, {:?} at 99 %; asked anew: moved {fresh_moved}, too hard {fresh_harder}",
            at(0.5),
            at(0.99),
        );
    }
    Ok(())
}

/// All pairs within 5 cm, with gradients, against a plain loop of distances.
fn near_pairs(
    checker: &mut Checker,
    obstacles: &[Shape],
    configs: &[Vec<f64>],
) -> Result<(), Box<dyn Error>> {
    const WITHIN: f64 = 0.05;
    let (mut found, options) = (NearPairs::default(), ClearanceOptions::default());
    let (mut count, mut differ, mut workspace) = (0, 0, Workspace::new());
    let mut times = [Vec::new(), Vec::new()];
    for q in configs {
        let start = ThreadTime::now();
        let _ = checker.near_pairs(q, WITHIN, &options, Budget::unlimited(), &mut found)?;
        times[0].push(start.elapsed());
        count += found.pairs.len();
        let start = ThreadTime::now();
        let model = checker.model();
        let poses = model.link_poses(q)?;
        let links = model.description().links.iter().zip(poses);
        let mut shapes: Vec<(Pose, &Shape)> = Vec::new();
        for (link, pose) in links {
            for (own, shape) in &link.shapes {
                shapes.push((pose.compose(own)?, shape));
            }
        }
        shapes.extend(obstacles.iter().map(|shape| (Pose::IDENTITY, shape)));
        let mut near = 0;
        for pair in checker.pairs() {
            let [a, b] = pair.map(|id| &shapes[id.number() as usize]);
            let b_in_a = a.0.inverse()?.compose(&b.0)?;
            let query = Query::distance(a.1.surface(), b.1.surface(), b_in_a);
            let query = query.absolute_tolerance(1e-6);
            let bounds = query.run(&mut workspace, Budget::unlimited()).value;
            near += usize::from(bounds.low <= WITHIN);
        }
        times[1].push(start.elapsed());
        differ += near.abs_diff(found.pairs.len());
    }
    for (name, times) in ["pairs within 5 cm", "a plain loop"].iter().zip(&mut times) {
        times.sort_unstable();
        let mean = times.iter().sum::<Duration>() / times.len() as u32;
        let [median, late] = [times.len() / 2, times.len() * 95 / 100].map(|i| times[i]);
        println!("{name}: median {median:?}, mean {mean:?}, 95 % {late:?}");
    }
    println!(
        "{count} pairs in {} configurations, {differ} differ",
        configs.len()
    );
    Ok(())
}
