//! `punctual contacts`: two meshes, a list of poses, where they meet or come close at each.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use punctual::clock::SystemClock;
use punctual::contacts::{Contact, ContactBounds, Contacts, Manifold, ManifoldBounds};
use punctual::glam::DVec3;
use punctual::{Budget, PairMemory, Pose, Query, ResumeError, StopReason, Tree, Workspace};
use punctual_depenetrate::{Penetration, PenetrationQuery, PenetrationWorkspace};
use punctual_lab::report::Failure;

use crate::Completion;
use crate::input::{Input, LoadedInput, Running, build_options, parse_size, print_source, vector};
use crate::view::{self, ViewArgs};

/// Where two meshes meet or come close, at each pose of a list.
///
/// Prints CSV, for each pose a line for each contact, that is, each pair of triangles no farther apart than the margin, the
/// nearest first; then a line for each patch, that is, each manifold of the surfaces within the margin, the deepest first. A pose
/// without contacts has one line of the kind none, one that is no pose a line that says error.
///
/// Of a contact: the patch with the point nearest to its middle; the triangles, counted from 0; the closest points a and b of
/// these, or of triangles that meet the ends of the segment in which they do; the unit normal n from B to A; and the distance, 0
/// only if they meet. Of a patch: its number, the middle of its area (a), its normal, and the least distance, 0 if its surfaces
/// meet. All is in A's frame, lengths are in the unit of the meshes. The normal of surfaces that meet takes triangles as
/// counterclockwise seen from outside; it is 0 0 0 where no direction parts them.
///
/// low is proven: every contact that is missing is at least that far apart; inf where none is. ns is the least time of all
/// sweeps: of the query for contacts on their lines, and of the query for manifolds, less that one, on lines of patches. stop
/// tells why the query ended. All but ns is of the first sweep. Both queries have a budget of the same size.
///
/// With --solid a line of the kind overlap follows for each point of each patch whose surfaces meet: the patch, the points on A
/// and on B, the normal, and the distance, which is minus the depth there. Where the surfaces do not meet, but one of the meshes is inside the
/// other, which is closed, a line of the kind contained has a or b in place of a patch: the inner one.
///
/// With --push a last line of each pose says which way (n) and how far (distance) B has to be moved until it is free, as proven
/// by an exact query; 0 if it is, empty if the budget ended before a push was found.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    /// How far apart the triangles of a contact may be; 0: they meet.
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = parse_size, allow_negative_numbers = true)]
    margin: f64,
    /// Stop at this many contacts of a pose; those may not be the nearest.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    max: Option<u32>,
    #[command(flatten)]
    running: Running,
    /// Take the poses as consecutive frames: a patch keeps its number while it keeps a point of the frame before. Otherwise numbers begin anew with each pose.
    #[arg(long)]
    memory: bool,
    /// Take the meshes as solids: print how deep they are sunk into each other, and which way out.
    #[arg(long)]
    solid: bool,
    /// Look for the shortest push that parts the surfaces too, within a budget of the same size.
    #[arg(long)]
    push: bool,
    #[command(flatten)]
    view: ViewArgs,
}

pub fn run(args: &Args, out: &mut impl Write) -> Result<Completion, Failure> {
    let LoadedInput { a, b, build, poses } = args.input.load(&build_options(args.solid))?;
    args.input.complain_of_open([&a, &b]);
    let completion = args.input.complain_of_bad_poses(&poses);
    let mut workspace = args.running.workspace();
    let pushes = || PenetrationWorkspace::with_engine(args.running.workspace());
    let mut pushes = args.push.then(pushes);
    let rows = args
        .running
        .answers(&poses, PairMemory::new, |&pose, memory, budget| {
            if !args.memory {
                *memory = PairMemory::new();
            }
            let answer = args.answer([&a, &b], pose, memory, &mut workspace);
            // A query goes on in the workspace that it has begun in.
            let (mut answer, [asked, of_patches]) = answer.ok()?;
            let start = Instant::now();
            answer.push = pushes.as_mut().map(|workspace| {
                let query = PenetrationQuery::new(&a, &b, pose).push_only(true);
                query.run(workspace, budget)
            });
            Some((answer, [asked, of_patches, start.elapsed()]))
        });
    print_source(out, build)?;
    writeln!(
        out,
        "pose,kind,patch,triangle_a,triangle_b,ax,ay,az,bx,by,bz,nx,ny,nz,distance,low,ns,stop"
    )?;
    for (i, row) in rows.iter().enumerate() {
        match row {
            Some((answer, times)) => answer.print(out, i, times, args.solid)?,
            None => writeln!(out, "{i},,,,,,,,,,,,,,,,0,error")?,
        }
    }
    args.view.write(
        args.input.meshes.up(),
        view::answered(&poses, &rows),
        |(pose, (answer, _))| {
            let (bodies, most) = (
                args.input.bodies([&a, &b]),
                args.max.map(|most| most as usize),
            );
            punctual_view::contacts(&bodies, args.query(&a, &b, *pose), pose, most, &answer.said)
        },
    )?;
    Ok(completion)
}

impl Args {
    fn query<'t>(&self, a: &'t Tree, b: &'t Tree, pose: Pose) -> Query<'t, Contacts> {
        let query = Query::contacts(a, b, pose).margin(self.margin);
        self.max
            .map_or(query, |most| query.contact_limit(most as usize))
    }

    /// The contacts and the manifolds of a pose, each within a budget of the same size, and the times that
    /// they took.
    fn answer(
        &self,
        [a, b]: [&Tree; 2],
        pose: Pose,
        memory: &mut PairMemory,
        workspace: &mut Workspace,
    ) -> Result<(Answer, [Duration; 2]), ResumeError> {
        let (budget, clock) = (self.running.limits.budget(), SystemClock::default());
        let most = self.max.map_or(usize::MAX, |most| most as usize);
        let (query, start) = (self.query(a, b, pose), Instant::now());
        let mut said = query.run(workspace, budget.clock(&clock));
        while let Some(left) = self.more_room(&said, most, workspace) {
            said = query.resume(workspace, left.clock(&clock))?;
        }
        let asked = start.elapsed();
        let contacts = workspace.contacts().copied().collect();
        let query = Query::manifolds(a, b, pose).skin(self.margin);
        let start = Instant::now();
        let begun = query.with_memory(&mut *memory);
        let mut of_patches = begun.run(workspace, budget.clock(&clock));
        while let Some(left) = self.more_room(&of_patches, usize::MAX, workspace) {
            let begun = query.with_memory(&mut *memory);
            of_patches = begun.resume(workspace, left.clock(&clock))?;
        }
        let times = [asked, start.elapsed()];
        let patches = workspace.manifolds().to_vec();
        let answer = Answer {
            said,
            contacts,
            of_patches,
            patches,
            push: None,
        };
        Ok((answer, times))
    }

    /// What is left of the budget, with more room for contacts, if an answer lacks only that and there are
    /// not so many.
    fn more_room<V>(
        &self,
        said: &punctual::Answer<V>,
        most: usize,
        workspace: &mut Workspace,
    ) -> Option<Budget> {
        let is_full = said.stop == StopReason::PairsFull && workspace.contacts().len() < most;
        is_full.then(|| {
            workspace.reserve_contacts(2 * said.stats.found as usize);
            let elapsed = said.stats.elapsed.unwrap_or_default();
            self.running.limits.budget_left(elapsed, said.stats.work)
        })
    }
}

/// What was found at a pose.
struct Answer {
    said: punctual::Answer<ContactBounds>,
    contacts: Vec<Contact>,
    of_patches: punctual::Answer<ManifoldBounds>,
    patches: Vec<Manifold>,
    push: Option<punctual::Answer<Penetration>>,
}

impl Answer {
    /// The number of the patch with the point nearest to a contact's middle; nothing without patches.
    fn patch_of(&self, contact: &Contact) -> String {
        let middle = |[p, q]: [DVec3; 2]| 0.5 * p + 0.5 * q;
        let place = middle(contact.points);
        let from = |patch: &Manifold| {
            let distances = patch
                .points()
                .iter()
                .map(|point| middle(point.points).distance_squared(place));
            distances.fold(f64::INFINITY, f64::min)
        };
        let nearest = self
            .patches
            .iter()
            .min_by(|x, y| from(x).total_cmp(&from(y)));
        nearest.map_or_else(String::new, |patch| patch.id.to_string())
    }

    fn print(
        &self,
        out: &mut impl Write,
        pose: usize,
        &[asked, of_patches, pushed]: &[Duration; 3],
        with_overlaps: bool,
    ) -> io::Result<()> {
        let (low, stop, ns) = (self.said.value.low, self.said.stop, asked.as_nanos());
        for contact in &self.contacts {
            let patch = self.patch_of(contact);
            let [a, b] = contact.triangles;
            let [p, q] = contact.segment.unwrap_or(contact.points).map(vector);
            let (n, distance) = (vector(contact.normal), contact.distance);
            writeln!(
                out,
                "{pose},contact,{patch},{a},{b},{p},{q},{n},{distance},{low},{ns},{stop}"
            )?;
        }
        if self.contacts.is_empty() {
            writeln!(out, "{pose},none,,,,,,,,,,,,,,{low},{ns},{stop}")?;
        }
        let (low, stop) = (self.of_patches.value.low, self.of_patches.stop);
        let ns = of_patches.saturating_sub(asked).as_nanos();
        for patch in &self.patches {
            let (id, p, n) = (patch.id, vector(patch.centroid), vector(patch.normal));
            let distance = if patch.is_overlap {
                0.0
            } else {
                patch.distance
            };
            writeln!(
                out,
                "{pose},patch,{id},,,{p},,,,{n},{distance},{low},{ns},{stop}"
            )?;
        }
        let overlaps = self.patches.iter().filter(|one| one.is_overlap);
        for patch in overlaps.filter(|_| with_overlaps) {
            for point in patch.points() {
                let ([p, q], n) = (point.points.map(vector), vector(point.normal));
                let (id, distance) = (patch.id, point.distance);
                writeln!(
                    out,
                    "{pose},overlap,{id},,,{p},{q},{n},{distance},{low},{ns},{stop}"
                )?;
            }
        }
        if let Some(inner) = self.of_patches.value.within {
            writeln!(
                out,
                "{pose},contained,{inner},,,,,,,,,,,,,{low},{ns},{stop}"
            )?;
        }
        let Some(found) = &self.push else {
            return Ok(());
        };
        let (Penetration { high, .. }, stop) = (found.value, found.stop);
        let n = found.value.direction.unwrap_or(DVec3::X);
        // Empty where the budget ended before a push was found.
        let push = if high < f64::INFINITY {
            format!("{},{high}", vector(n))
        } else {
            ",,,".into()
        };
        let ns = pushed.as_nanos();
        writeln!(out, "{pose},push,,,,,,,,,,{push},,{ns},{stop}")
    }
}
