//! What a scene is asked beside verdicts, and the files that its answers go to.

use std::fmt::Arguments;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Add;
use std::path::{Path, PathBuf};

use punctual::{Budget, Ray};
use punctual_io::FileError;
use punctual_lab::files::{self, Listed};
use punctual_lab::report::{self, Failure};
use punctual_scene::{BodyHit, BodyId, ContactPhase, Scene, SceneRay};

use crate::input::{parse_size, vector};

#[derive(clap::Args)]
pub struct Questions {
    /// Also find where bodies touch: a line tells of how many pairs contacts were found, and of how many all were; contacts.csv.
    #[arg(long)]
    contacts: bool,
    /// Also measure how far apart two bodies are, by their numbers in the file, as often as given; distances.csv.
    #[arg(long, value_name = "A,B", value_parser = parse_bodies)]
    measure: Vec<[usize; 2]>,
    /// Stop measuring as soon as high - low <= D.
    #[arg(long, value_name = "D", default_value_t = 0.0, value_parser = parse_size, requires = "measure")]
    tolerance: f64,
    /// Also tell until when each pair is free on its way to the next frame, on a screw motion; passages.csv.
    #[arg(long)]
    motions: bool,
    /// Also tell which contacts of bodies begin, persist and end; events.csv.
    #[arg(long)]
    events: bool,
    /// After each frame, without a budget, find what these rays hit first, one a line: 6 numbers, the origin and the
    /// direction; hits.csv.
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,
    /// Write the answers, a line each, to the files named above in this folder, which is made if it does not exist.
    #[arg(long, value_name = "DIR")]
    answers: Option<PathBuf>,
}

fn parse_bodies(text: &str) -> Result<[usize; 2], String> {
    let bodies = text
        .split_once(',')
        .and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    bodies.ok_or_else(|| "must be the numbers of two bodies, as in 0,5".into())
}

impl Questions {
    /// Whether bodies are told where they go.
    pub fn moves(&self) -> bool {
        self.motions
    }

    /// Asks a scene, whose bodies are these.
    pub fn ask(&self, scene: &mut Scene, ids: &[BodyId]) -> Result<(), Failure> {
        if self.contacts {
            scene.find_contacts();
        }
        if self.events {
            scene.track_contacts();
        }
        for bodies in &self.measure {
            let id = |body: usize| {
                ids.get(body)
                    .copied()
                    .ok_or_else(|| format!("--measure: no body {body}"))
            };
            scene.measure(id(bodies[0])?, id(bodies[1])?, self.tolerance)?;
        }
        Ok(())
    }

    /// Whether the scene is asked anything.
    pub fn any(&self) -> bool {
        self.contacts || self.events || self.motions || !self.measure.is_empty()
    }

    /// Opens the files of what is asked, or of `all` answers, and reads the rays.
    pub fn open(&self, all: bool) -> Result<Answers, Failure> {
        let rays = self.rays.as_deref().map_or(Ok(Vec::new()), read_rays)?;
        if let Some(folder) = &self.answers {
            report::create_folder(folder)?;
        }
        let table = |asked: bool, name: &str, columns: &str| {
            let folder = self.answers.as_ref().filter(|_| asked || all);
            let mut table = Table(
                folder
                    .map(|folder| File::create(folder.join(name)).map(BufWriter::new))
                    .transpose()?,
            );
            table.line(format_args!("{columns}"))?;
            io::Result::Ok(table)
        };
        let contacts = "frame,a,b,manifold,point,ax,ay,az,bx,by,bz,nx,ny,nz,distance,age,drift";
        let distances = "frame,a,b,low,high,triangle_a,triangle_b,age";
        let passages = "frame,a,b,free_until,touching_at,triangle_a,triangle_b";
        let events = "frame,a,b,phase,age";
        let hits = "frame,ray,body,triangle,t,side";
        Ok(Answers {
            contacts: table(self.contacts, "contacts.csv", contacts)?,
            distances: table(!self.measure.is_empty(), "distances.csv", distances)?,
            passages: table(self.motions, "passages.csv", passages)?,
            events: table(self.events, "events.csv", events)?,
            hits: table(!rays.is_empty(), "hits.csv", hits)?,
            rays,
            locates: self.contacts || all,
        })
    }
}

fn read_rays(file: &Path) -> Result<Vec<SceneRay>, FileError> {
    let ray = |listed: Listed<Ray>| {
        listed
            .entry
            .map_err(|what| FileError::at_line(file, listed.line, what))
            .map(SceneRay::new)
    };
    files::rays(file, false)?.into_iter().map(ray).collect()
}

/// A CSV file, if it is wanted.
struct Table(Option<BufWriter<File>>);

impl Table {
    fn line(&mut self, line: Arguments) -> io::Result<()> {
        self.0
            .as_mut()
            .map_or(Ok(()), |file| writeln!(file, "{line}"))
    }
}

/// How often what was answered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Pairs whose contacts were found in this frame, and those of them that were all found.
    pub touching: [usize; 2],
    /// Distances asked for, and those proven in this frame.
    pub distances: [usize; 2],
    /// Pairs with a motion, those proven to be free to its end, and those proven to meet.
    pub passages: [usize; 3],
    /// Contacts of bodies that began, and that ended.
    pub events: [usize; 2],
    /// Rays cast, and those that hit.
    pub rays: [usize; 2],
}

impl Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        fn sum<const N: usize>(mut a: [usize; N], b: [usize; N]) -> [usize; N] {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        }
        Self {
            touching: sum(self.touching, other.touching),
            distances: sum(self.distances, other.distances),
            passages: sum(self.passages, other.passages),
            events: sum(self.events, other.events),
            rays: sum(self.rays, other.rays),
        }
    }
}

/// The files, and the rays that are cast.
pub struct Answers {
    contacts: Table,
    distances: Table,
    passages: Table,
    events: Table,
    hits: Table,
    rays: Vec<SceneRay>,
    /// Whether contacts are asked for.
    locates: bool,
}

impl Answers {
    /// Writes and counts what the scene says after a frame.
    pub fn frame(&mut self, frame: usize, scene: &mut Scene) -> Result<Counts, Failure> {
        let mut counts = Counts::default();
        let report = scene.report();
        for pair in report.pairs.iter().filter(|_| self.locates) {
            let found = scene.contacts(pair.a, pair.b)?;
            let poses = [&scene.body(pair.a)?.pose, &scene.body(pair.b)?.pose];
            let bodies = numbers([pair.a, pair.b]);
            for point in found.points {
                let now = point.at(poses);
                let ([a, b], normal) = (now.points.map(vector), vector(now.normal));
                let line = format_args!(
                    "{frame},{bodies},{},{},{a},{b},{normal},{},{},{}",
                    point.manifold, point.id, now.distance, found.age, found.drift
                );
                self.contacts.line(line)?;
            }
            if found.drift == 0.0 && !found.points.is_empty() {
                counts.touching[0] += 1;
                counts.touching[1] += usize::from(found.is_complete());
            }
        }
        let pair = |triangles: Option<[u32; 2]>| triangles.map_or(",".into(), list);
        for found in scene.distances() {
            let (bodies, triangles) = (numbers([found.a, found.b]), pair(found.triangles));
            let (low, high, age) = (found.low, found.high, found.age);
            let line = format_args!("{frame},{bodies},{low},{high},{triangles},{age}");
            self.distances.line(line)?;
            counts.distances[0] += 1;
            counts.distances[1] += usize::from(age == 0);
        }
        for found in scene.passages() {
            let (bodies, triangles) = (numbers([found.a, found.b]), pair(found.triangles));
            let (free, hit) = (found.free_until, found.touching_at);
            let touching = hit.map_or(String::new(), |time| time.to_string());
            let line = format_args!("{frame},{bodies},{free},{touching},{triangles}");
            self.passages.line(line)?;
            counts.passages[0] += 1;
            counts.passages[1] += usize::from(free == 1.0 && hit.is_none());
            counts.passages[2] += usize::from(hit.is_some());
        }
        for contact in &report.contacts {
            let (bodies, phase) = (numbers([contact.a, contact.b]), contact.phase);
            let line = format_args!("{frame},{bodies},{phase},{}", contact.age);
            self.events.line(line)?;
            counts.events[0] += usize::from(phase == ContactPhase::Began);
            counts.events[1] += usize::from(phase == ContactPhase::Ended);
        }
        for (number, ray) in self.rays.iter().enumerate() {
            let hit = scene.cast(ray, Budget::unlimited())?.hit;
            let told = hit.map_or(
                ",,,".into(),
                |BodyHit {
                     body, on_body: hit, ..
                 }| {
                    format!("{},{},{},{}", body.index(), hit.triangle, hit.t, hit.side)
                },
            );
            self.hits.line(format_args!("{frame},{number},{told}"))?;
            counts.rays[0] += 1;
            counts.rays[1] += usize::from(hit.is_some());
        }
        Ok(counts)
    }
}

fn list<T: ToString>([a, b]: [T; 2]) -> String {
    format!("{},{}", a.to_string(), b.to_string())
}

fn numbers(bodies: [BodyId; 2]) -> String {
    list(bodies.map(BodyId::index))
}
