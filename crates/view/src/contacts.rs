//! A query of contacts: where triangles meet or come close, and which way they face each other.

use std::collections::HashSet;

use punctual::contacts::{Contact, ContactBounds, Contacts, Manifold, ManifoldPoint, Manifolds};
use punctual::{Aabb, Answer, Budget, Pose, Query, ResumeError, Stats, StopReason, Workspace};
use serde_json::{Value, json};

use crate::ladder::{Stepwise, climb};
use crate::stage::{NORMAL, OPEN_BOXES, Stage, count, fact, length, placed, tests};
use crate::{Bodies, View};

/// Contacts that are drawn, the first that were found.
const MOST_CONTACTS: usize = 10_000;

/// A page for a query of these bodies at this pose, which ends at `most` contacts, and which was answered so. Of two solids it
/// shows where and how deep they are sunk into each other, too.
pub fn contacts(
    bodies: &Bodies,
    query: Query<Contacts>,
    pose: &Pose,
    most: Option<usize>,
    answer: &Answer<ContactBounds>,
) -> Result<View, ResumeError> {
    let [a, b] = bodies.trees;
    let mut stage = Stage::new(placed(a, &Pose::IDENTITY).union(&placed(b, pose)));
    let placed = stage.bodies(bodies, pose);
    let arrays = [0; 2].map(|_| stage.arrays.add());
    let is_solid = bodies.trees.iter().all(|tree| tree.solid().is_some());
    let depths = is_solid.then(|| {
        let query = Query::manifolds(a, b, *pose);
        draw_overlaps(&mut stage, query, arrays[1])
    });
    let mut surfaces = stage.both(&placed);
    if is_solid {
        surfaces.extend(draw_sunk(&mut stage, bodies, pose, placed));
    }
    let mut steps = Steps {
        query,
        most,
        workspace: Workspace::new(),
        surfaces,
        drawn: HashSet::new(),
        around: Aabb::EMPTY,
        arrays,
        depths,
    };
    let steps = climb(&mut steps, &mut stage, answer)?;
    let mut layers = vec![
        ("met", "contacts"),
        ("normal", "normals, from B to A"),
        ("box", OPEN_BOXES),
    ];
    if depths.is_some() {
        layers.push(("near", "depths of overlaps"));
        layers.push(("sunk", "triangles with a corner inside the other"));
    }
    Ok(View::of_query(
        "Where two meshes touch",
        bodies,
        &layers,
        stage,
        steps,
    ))
}

/// Draws the normals at the points of all overlaps. Returns the array of their depths.
fn draw_overlaps(stage: &mut Stage, query: Query<Manifolds>, normals: usize) -> usize {
    let depths = stage.arrays.add();
    let mut workspace = Workspace::new();
    let mut answer = query.run(&mut workspace, Budget::unlimited());
    while answer.stop == StopReason::PairsFull {
        workspace.reserve_contacts(2 * answer.stats.found as usize);
        match query.resume(&mut workspace, Budget::unlimited()) {
            Ok(next) => answer = next,
            Err(_) => break,
        }
    }
    let long = NORMAL * stage.radius();
    let points = || workspace.manifolds().iter().flat_map(Manifold::points);
    let normal = |point: &ManifoldPoint| [point.points[1], point.points[1] + long * point.normal];
    stage.segments(depths, points().map(|point| point.points));
    stage.segments(normals, points().map(normal));
    depths
}

/// The triangles of each body that have a corner inside the other or on its surface.
fn draw_sunk(
    stage: &mut Stage,
    bodies: &Bodies,
    b_in_a: &Pose,
    placed: [[usize; 2]; 2],
) -> Vec<Value> {
    let [a, b] = bodies.trees;
    let into = [b_in_a.inverse().ok(), Some(*b_in_a)];
    let mut workspace = Workspace::new();
    let mut draw = |side: usize| {
        let (tree, other) = ([a, b][side], [b, a][side]);
        let mesh = tree.mesh();
        let into = into[side]?;
        let points: Vec<[f64; 3]> = (0..mesh.vertex_count())
            .map(|i| into.transform_point(mesh.vertex(i)).to_array())
            .collect();
        let query = Query::windings(other, &points).ok()?;
        let _ = query.run(&mut workspace, Budget::unlimited());
        let bounds = workspace.points();
        let is_inside = |&i: &u32| bounds[i as usize].inside == Some(true);
        let sunk = (0..).zip(mesh.triangles());
        let sunk: Vec<u32> = sunk
            .filter(|(_, corners)| corners.iter().any(is_inside))
            .map(|(id, _)| id)
            .collect();
        let array = stage.arrays.add();
        let range = stage.triangles(array, tree, sunk);
        let [mesh, pose] = placed[side];
        Some(json!(["sunk", mesh, pose, range]))
    };
    [draw(0), draw(1)].into_iter().flatten().collect()
}

struct Steps<'t> {
    query: Query<'t, Contacts>,
    most: Option<usize>,
    workspace: Workspace,
    /// Both bodies, and where they are sunk into each other.
    surfaces: Vec<Value>,
    drawn: HashSet<[u32; 2]>,
    around: Aabb,
    /// Of contacts and of normals, in the order of discovery.
    arrays: [usize; 2],
    /// Of the depths of overlaps.
    depths: Option<usize>,
}

impl Steps<'_> {
    /// Makes more room where contacts need it.
    fn make_room(
        &mut self,
        mut said: Answer<ContactBounds>,
        until: u64,
    ) -> Result<Answer<ContactBounds>, ResumeError> {
        while said.stop == StopReason::PairsFull && self.most.is_none() {
            let found = self.workspace.contacts().len();
            self.workspace.reserve_contacts(2 * found);
            said = self
                .query
                .resume(&mut self.workspace, Budget::work(until - said.stats.work))?;
        }
        Ok(said)
    }

    fn draw(&mut self, stage: &mut Stage) -> Value {
        let room = MOST_CONTACTS - self.drawn.len();
        let new = self
            .workspace
            .contacts()
            .filter(|contact| !self.drawn.contains(&contact.triangles));
        let new: Vec<Contact> = new.take(room).copied().collect();
        self.drawn
            .extend(new.iter().map(|contact| contact.triangles));
        let long = NORMAL * stage.radius();
        let place = |contact: &Contact| contact.segment.unwrap_or(contact.points);
        let normal =
            |contact: &Contact| [contact.points[1], contact.points[1] + long * contact.normal];
        let [places, normals] = self.arrays;
        stage.segments(places, new.iter().map(place));
        stage.segments(normals, new.iter().map(normal));
        self.around = self
            .around
            .union(&Aabb::from_points(new.iter().flat_map(place)));
        let mut lines = vec![
            ("normal", stage.arrays.so_far(normals)),
            ("met", stage.arrays.so_far(places)),
        ];
        lines.extend(
            self.depths
                .map(|depths| ("near", stage.arrays.so_far(depths))),
        );
        json!(lines)
    }
}

impl Stepwise for Steps<'_> {
    type Answer = Answer<ContactBounds>;

    fn begin(&mut self, until: u64) -> Result<Answer<ContactBounds>, ResumeError> {
        let said = self.query.run(&mut self.workspace, Budget::work(until));
        self.make_room(said, until)
    }

    fn resume(
        &mut self,
        stopped: &Answer<ContactBounds>,
        until: u64,
    ) -> Result<Answer<ContactBounds>, ResumeError> {
        let said = self.query.resume(
            &mut self.workspace,
            Budget::work(until - stopped.stats.work),
        )?;
        self.make_room(said, until)
    }

    fn reached(answer: &Answer<ContactBounds>) -> (StopReason, Stats) {
        (answer.stop, answer.stats)
    }

    fn look(
        &mut self,
        said: &Answer<ContactBounds>,
        stage: &mut Stage,
    ) -> Result<Value, ResumeError> {
        let certificate = self.query.certificate(&self.workspace)?;
        let (boxes, open, remark) = stage.open_boxes(&certificate);
        let none = if certificate.open_pairs() > 0 {
            "none yet"
        } else {
            "none"
        };
        let nearest = self
            .workspace
            .contacts()
            .next()
            .map_or(none.to_owned(), |contact| length(contact.distance));
        let lines = self.draw(stage);
        let drawn = self.drawn.len() as u64;
        let mut remarks = Vec::from_iter(remark);
        let found = "Contacts found";
        if said.stats.found > drawn {
            remarks.push(fact(found, format!("{} are drawn", count(drawn))));
        }
        let mut facts = vec![
            fact(found, count(said.stats.found)),
            fact("Least distance found", nearest),
            fact(
                "Missing ones are apart by",
                if said.value.low.is_finite() {
                    length(said.value.low)
                } else {
                    "none is missing".into()
                },
            ),
        ];
        facts.extend(open);
        facts.extend(tests(&said.stats));
        let (surfaces, focus) = (&self.surfaces, stage.focus(&self.around));
        Ok(
            json!({ "facts": facts, "remarks": remarks, "surfaces": surfaces, "boxes": boxes, "lines": lines, "focus": focus }),
        )
    }
}
