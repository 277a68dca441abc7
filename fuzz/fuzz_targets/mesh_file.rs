//! Mesh files of any bytes: refused, or a mesh of which a tree can be built.

#![no_main]

use libfuzzer_sys::fuzz_target;
use punctual::Tree;
use punctual_io::{Format, Loaded, read};

fuzz_target!(|data: &[u8]| {
    let Some((&format, bytes)) = data.split_first() else {
        return;
    };
    let formats = [
        Format::Obj,
        Format::Stl,
        Format::Ply,
        Format::Gltf,
        Format::Off,
        Format::Collada,
    ]
    .map(Some);
    match read(
        bytes,
        formats.get(usize::from(format % 7)).copied().flatten(),
    ) {
        Ok(Loaded { mesh, notices, .. }) => {
            assert!(!mesh.is_empty());
            assert_eq!(Tree::new(mesh).validate(), Ok(()));
            assert!(
                notices.len() < 20
                    && notices
                        .iter()
                        .all(|notice| notice.to_string().len() < 10_000)
            );
        }
        Err(error) => assert!(error.to_string().len() < 10_000),
    }
});
