//! Mesh files of any bytes: refused, or a mesh of which a tree can be built.

#![no_main]

use libfuzzer_sys::fuzz_target;
use punctual::Tree;
use punctual_io::{Format, read};

fuzz_target!(|data: &[u8]| {
    let Some((&format, bytes)) = data.split_first() else { return };
    let format = [Format::Obj, Format::Stl, Format::Ply, Format::Glb][usize::from(format % 4)];
    match read(bytes, format) {
        Ok(mesh) => {
            assert!(!mesh.is_empty());
            assert_eq!(Tree::new(mesh).validate(), Ok(()));
        }
        Err(error) => assert!(error.to_string().len() < 10_000),
    }
});
