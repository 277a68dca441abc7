//! Measures a robot in its cell: `measure DIR [labels|clearance|edges|horizon [REPETITIONS]]`, with
//! the files of one robot:
//! `robot.urdf`, `robot.srdf`, `env/`, `configs.csv`, `labels.csv`, `clearance.csv`, `edges.csv`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use punctual::{Budget, Pose};
use punctual_robot::{
    Checker, ClearanceOptions, Collision, EdgeAnswer, EdgeOptions, Margin, Model, Shape,
    UrdfOptions,
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
    for file in files {
        let name = file
            .path()
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let mesh = punctual_io::load(&file.path())?.mesh;
        checker.add(&name, Pose::IDENTITY, Shape::mesh(mesh))?;
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
