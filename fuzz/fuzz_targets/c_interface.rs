//! Any sequence of calls of the C interface, some of their arguments wrong, against a plain model: a call fails if, and only
//! if, an argument was wrong, with a status for one of those; a failure writes nothing; verdicts, pairs and bounds are those
//! of all pairs of triangles. The sanitizers see that arrays are kept to and that all that was made is freed, once.
#![no_main]

#[path = "c_interface/call.rs"]
mod call;
#[path = "c_interface/queries.rs"]
mod queries;
#[path = "c_interface/scenes.rs"]
mod scenes;
#[path = "c_interface/surfaces.rs"]
mod surfaces;

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use punctual_capi::*;
use queries::Desk;
use scenes::Stage;
use surfaces::{Grown, Surface};

/// All handles, each with what the model knows of it.
#[derive(Default)]
struct World {
    surfaces: Vec<Surface>,
    trees: Vec<Grown>,
    desks: Vec<Desk>,
    #[expect(clippy::vec_box, reason = "the handle that C has")]
    memories: Vec<Box<punctual_memory>>,
    stages: Vec<Stage>,
}

impl World {
    fn play(&mut self, bytes: &mut Unstructured) -> Result<()> {
        while !bytes.is_empty() {
            match bytes.int_in_range(0..=15)? {
                0 | 1 => surfaces::change(self, bytes)?,
                2 => surfaces::numbers(bytes)?,
                3..=5 => surfaces::grow(self, bytes)?,
                6..=10 => queries::play(self, bytes)?,
                _ => scenes::play(self, bytes)?,
            }
        }
        Ok(())
    }

    /// In an order that nothing but the header allows: trees before the scenes that share them.
    fn free(self) {
        self.surfaces
            .into_iter()
            .for_each(|surface| punctual_mesh_free(Some(surface.handle)));
        self.trees
            .into_iter()
            .for_each(|tree| punctual_tree_free(Some(tree.handle)));
        self.desks
            .into_iter()
            .for_each(|desk| punctual_workspace_free(Some(desk.workspace)));
        self.memories
            .into_iter()
            .for_each(|memory| punctual_memory_free(Some(memory)));
        self.stages
            .into_iter()
            .for_each(|stage| punctual_scene_free(Some(stage.scene)));
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut world = World::default();
    let _ = world.play(&mut Unstructured::new(bytes));
    world.free();
});
