//! Recordings: the calls that change a scene, a line of JSON each.

use super::{
    Body, BodyId, BodyKind, CompoundId, Filter, GroupId, MeasureId, PairQuestion, Reach, Scene,
    SceneError,
};
use alloc::borrow::ToOwned;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use core::error::Error;
use core::fmt;
use core::mem;
use punctual::prediction::Calibration;
use punctual::{Budget, Mode, Tree};
use punctual_geom::{Motion, Pose};
use serde::{Deserialize, Serialize};
use serde_json::StreamDeserializer;
use serde_json::de::IoRead;
use std::io::{self, Read, Write};

/// A line of a recording: a call of [`Scene`], or a tree for the calls below it. A tree has the
/// number of trees before it.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Call {
    /// The version of this crate that wrote the recording.
    Version(String),
    /// [`Tree::to_bytes`] in base64.
    Tree(String),
    /// An earlier tree with new vertices. What is known of pairs of that one helps this one.
    Refit(usize, Vec<[f64; 3]>),
    Insert(Part),
    InsertCompound(Pose, Vec<Part>),
    Remove(BodyId),
    RemoveCompound(CompoundId),
    SetPose(BodyId, Pose),
    SetMotion(BodyId, Motion),
    SetTree(BodyId, usize),
    /// The tree in place of the one that [`Scene::tree_mut`] gave.
    TreeMut(BodyId, usize),
    SetName(BodyId, String),
    SetFilter(BodyId, Filter),
    SetImportance(BodyId, f32),
    SetMargin(BodyId, f64),
    SetMode(Mode),
    SetReach(Reach),
    SetMaxPairs(usize),
    Reserve(usize, usize),
    SetQuestionImportance(PairQuestion, f32),
    SetCalibration(Calibration),
    Ignore(BodyId, BodyId, bool),
    Group(String),
    SetGroup(BodyId, Option<GroupId>),
    IgnoreGroups(GroupId, GroupId, bool),
    TrackContacts,
    FindContactsBetween(Filter),
    StopFindingContactsBetween(Filter),
    FindContactsOf(BodyId, BodyId),
    StopFindingContactsOf(BodyId, BodyId),
    SetLookAhead(f64),
    Measure(BodyId, BodyId, f64),
    StopMeasuring(BodyId, BodyId),
    MeasureGroups(Vec<BodyId>, Vec<BodyId>, f64),
    StopMeasuringGroups(MeasureId),
    Detect(Budget),
}

/// A [`Body`] with the number of its tree.
#[derive(Serialize, Deserialize)]
pub(super) struct Part {
    tree: usize,
    pose: Pose,
    kind: BodyKind,
    filter: Filter,
    importance: f32,
    margin: f64,
    is_sensor: bool,
    data: u64,
}

/// The most bodies and pairs that a replay [reserves](Scene::reserve) room for: a damaged number
/// must not take all memory.
const ROOM: usize = 1 << 20;

/// Where a scene writes its calls.
pub(super) struct Recorder {
    file: Box<dyn Write + Send + Sync>,
    /// The first error of the file, which ends the recording.
    written: io::Result<()>,
    /// Identity and lineage of each tree.
    trees: Vec<[usize; 2]>,
    /// Bodies whose trees may have been changed in place since the last line.
    pub open_trees: Vec<BodyId>,
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Recorder").field(&self.written).finish()
    }
}

impl Recorder {
    fn write(&mut self, call: &Call) {
        if self.written.is_ok() {
            self.written = self.line(call);
        }
    }

    fn line(&mut self, call: &Call) -> io::Result<()> {
        let mut line = serde_json::to_vec(call)?;
        line.push(b'\n');
        self.file.write_all(&line)?;
        // Then the file has this frame even if it ends the program.
        match call {
            Call::Detect(_) => self.file.flush(),
            _ => Ok(()),
        }
    }

    /// The number of a tree, which is written if it is new.
    pub fn tree(&mut self, tree: &Tree) -> usize {
        let key @ [identity, lineage] = [tree.identity(), tree.lineage()];
        if let Some(number) = self.trees.iter().rposition(|known| known[0] == identity) {
            return number;
        }
        let mesh = tree.mesh();
        let vertices = || (0..mesh.vertex_count()).map(|vertex| mesh.vertex(vertex).to_array());
        self.write(
            &match self.trees.iter().rposition(|known| known[1] == lineage) {
                Some(earlier) => Call::Refit(earlier, vertices().collect()),
                None => Call::Tree(BASE64_STANDARD.encode(tree.to_bytes())),
            },
        );
        self.trees.push(key);
        self.trees.len() - 1
    }

    pub fn part(&mut self, scene: &Scene, id: BodyId, pose: Pose) -> Result<Part, SceneError> {
        let body = scene.body(id)?;
        Ok(Part {
            tree: self.tree(&body.tree),
            pose,
            kind: body.kind,
            filter: body.filter,
            importance: body.importance,
            margin: body.margin,
            is_sensor: body.is_sensor,
            data: body.data,
        })
    }
}

impl Scene {
    /// A new scene that writes each call that changes it to a file, for [`Replay`]. A call is a
    /// line of JSON, about 300 bytes for a pose; each tree is written once, about 40 bytes a
    /// triangle. Pass a [`BufWriter`](io::BufWriter), around a gzip encoder if the file is to be
    /// small. It is flushed at each [`Scene::detect`] before the frame begins.
    ///
    /// Calls that fail are left out, because they change nothing, and so are
    /// `use_threads` and questions between frames.
    ///
    /// ```
    /// use punctual::{Budget, Pose, Tree, shapes};
    /// use punctual_scene::{Body, Replay, Scene};
    /// use std::fs::File;
    /// use std::io::{BufReader, BufWriter};
    /// use std::sync::Arc;
    ///
    /// # let folder = std::env::temp_dir().join(format!("punctual-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder)?;
    /// let path = folder.join("odd.jsonl");
    /// let mut scene = Scene::recorded(BufWriter::new(File::create(&path)?));
    /// let ball = Arc::new(Tree::new(shapes::icosphere(2)));
    /// for x in [0.0, 1.5] {
    ///     let place = Pose::from_quat([0.0, 0.0, 0.0, 1.0], [x, 0.0, 0.0])?;
    ///     scene.insert(Body::moving(Arc::clone(&ball), place))?;
    /// }
    /// let pairs = scene.detect(Budget::work(10_000)).pairs.clone();
    /// scene.stop_recording()?;
    ///
    /// let (mut replay, mut again) = (Replay::new(BufReader::new(File::open(&path)?)), Scene::new());
    /// while let Some(budget) = replay.next_frame(&mut again)? {
    ///     assert_eq!(again.detect(budget).pairs, pairs);
    /// }
    /// # std::fs::remove_dir_all(&folder)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn recorded(file: impl Write + Send + Sync + 'static) -> Self {
        let mut recorder = Recorder {
            file: Box::new(file),
            written: Ok(()),
            trees: Vec::new(),
            open_trees: Vec::new(),
        };
        recorder.write(&Call::Version(env!("CARGO_PKG_VERSION").to_owned()));
        Self {
            recorder: Some(Box::new(recorder)),
            ..Self::new()
        }
    }

    /// Ends the recording of [`Scene::recorded`] and closes the file. A no-op if there is none.
    ///
    /// # Errors
    /// The first error that the file had. Nothing was written after it.
    pub fn stop_recording(&mut self) -> io::Result<()> {
        match self.recorder.take() {
            Some(mut recorder) => recorder.written.and_then(|()| recorder.file.flush()),
            None => Ok(()),
        }
    }

    /// Writes a call, after the trees that were changed before it.
    pub(super) fn record(
        &mut self,
        call: impl FnOnce(&Self, &mut Recorder) -> Result<Call, SceneError>,
    ) {
        let Some(mut recorder) = self.recorder.take() else {
            return;
        };
        for id in mem::take(&mut recorder.open_trees) {
            if let Ok(body) = self.body(id) {
                let call = Call::TreeMut(id, recorder.tree(&body.tree));
                recorder.write(&call);
            }
        }
        if let Ok(call) = call(self, &mut recorder) {
            recorder.write(&call);
        }
        self.recorder = Some(recorder);
    }
}

/// Plays what [`Scene::recorded`] wrote. With budgets of work, or none, the frames report the same
/// bits, on any number of threads.
pub struct Replay<R: Read> {
    calls: StreamDeserializer<'static, IoRead<R>, Call>,
    trees: Vec<Arc<Tree>>,
}

impl<R: Read> Replay<R> {
    /// Plays a recording from its begin. `file` should be buffered.
    pub fn new(file: R) -> Self {
        Self {
            calls: serde_json::Deserializer::from_reader(file).into_iter(),
            trees: Vec::new(),
        }
    }

    /// Changes a scene, at first an empty one, as the recorded scene was changed up to its next
    /// [`Scene::detect`], and returns the budget of that call; `None` after the last one. The
    /// caller runs the frame, with this budget or another one.
    ///
    /// # Errors
    /// If the file cannot be read or is not a recording; the error names the line or the byte. The
    /// scene has then been changed up to there.
    pub fn next_frame(&mut self, scene: &mut Scene) -> io::Result<Option<Budget>> {
        while let Some(call) = self.calls.next().transpose()? {
            if let Call::Detect(budget) = call {
                return Ok(Some(budget));
            }
            if let Err(error) = self.apply(call, scene) {
                let error = format!("call before byte {}: {error}", self.calls.byte_offset());
                return Err(io::Error::new(io::ErrorKind::InvalidData, error));
            }
        }
        Ok(None)
    }

    fn apply(&mut self, call: Call, scene: &mut Scene) -> Result<(), Box<dyn Error>> {
        match call {
            Call::Version(_) | Call::Detect(_) => {}
            Call::Tree(text) => {
                let tree = Tree::from_bytes(&BASE64_STANDARD.decode(text)?)?;
                self.trees.push(Arc::new(tree));
            }
            Call::Refit(earlier, vertices) => {
                let mut tree = Tree::clone(&*self.tree(earlier)?);
                tree.refit_f64(&vertices)?;
                self.trees.push(Arc::new(tree));
            }
            Call::Insert(part) => _ = scene.insert(self.body(part)?)?,
            Call::InsertCompound(pose, parts) => {
                let bodies = parts.into_iter().map(|part| self.body(part));
                scene.insert_compound(pose, bodies.collect::<Result<Vec<_>, _>>()?)?;
            }
            Call::Remove(id) => _ = scene.remove(id)?,
            Call::RemoveCompound(id) => scene.remove_compound(id)?,
            Call::SetPose(id, pose) => scene.set_pose(id, pose)?,
            Call::SetMotion(id, motion) => scene.set_motion(id, motion)?,
            Call::SetTree(id, tree) => scene.set_tree(id, self.tree(tree)?)?,
            Call::TreeMut(id, tree) => *scene.tree_mut(id)? = Tree::clone(&*self.tree(tree)?),
            Call::SetName(id, name) => scene.set_name(id, &name)?,
            Call::SetFilter(id, filter) => scene.set_filter(id, filter)?,
            Call::SetImportance(id, importance) => scene.set_importance(id, importance)?,
            Call::SetMargin(id, margin) => scene.set_margin(id, margin)?,
            Call::SetMode(mode) => scene.set_mode(mode),
            Call::SetReach(reach) => scene.set_reach(reach),
            Call::SetMaxPairs(pairs) => scene.set_max_pairs(pairs),
            Call::Reserve(bodies, pairs) => scene.reserve(bodies.min(ROOM), pairs.min(ROOM)),
            Call::SetQuestionImportance(question, importance) => {
                scene.set_question_importance(question, importance)?;
            }
            Call::SetCalibration(calibration) => scene.set_calibration(calibration),
            Call::Ignore(x, y, ignores) => scene.ignore(x, y, ignores)?,
            Call::Group(name) => _ = scene.group(&name),
            Call::SetGroup(id, group) => scene.set_group(id, group)?,
            Call::IgnoreGroups(x, y, ignores) => scene.ignore_groups(x, y, ignores)?,
            Call::TrackContacts => scene.track_contacts(),
            Call::FindContactsBetween(filter) => scene.find_contacts_between(filter),
            Call::StopFindingContactsBetween(filter) => scene.stop_finding_contacts_between(filter),
            Call::FindContactsOf(x, y) => scene.find_contacts_of(x, y)?,
            Call::StopFindingContactsOf(x, y) => scene.stop_finding_contacts_of(x, y)?,
            Call::SetLookAhead(length) => scene.set_look_ahead(length)?,
            Call::Measure(x, y, tolerance) => scene.measure(x, y, tolerance)?,
            Call::StopMeasuring(x, y) => scene.stop_measuring(x, y)?,
            Call::MeasureGroups(x, y, tolerance) => _ = scene.measure_groups(&x, &y, tolerance)?,
            Call::StopMeasuringGroups(id) => scene.stop_measuring_groups(id)?,
        }
        Ok(())
    }

    fn tree(&self, number: usize) -> Result<Arc<Tree>, String> {
        let tree = self.trees.get(number);
        tree.cloned().ok_or_else(|| format!("no tree {number}"))
    }

    fn body(&self, part: Part) -> Result<Body, String> {
        Ok(Body {
            tree: self.tree(part.tree)?,
            pose: part.pose,
            kind: part.kind,
            filter: part.filter,
            importance: part.importance,
            margin: part.margin,
            is_sensor: part.is_sensor,
            data: part.data,
        })
    }
}
