//! A tree as bytes: the loaded tree is the saved one to the bit, and damaged bytes are refused or are another tree with
//! true answers, whether or not their checksum was put right.

mod common;

use common::check::{ENOUGH, assert_complete, run, run_to_end};
use common::random::{Drift, Family, Random, pose_about, soup};
use common::reference::all_pairs;
use common::{MODES, ORDERS};
use punctual::glam::{DVec3, Vec3};
use punctual::tree::{TreeFault, TreeFileError};
use punctual::{
    BuildOptions, Certificate, Mesh, MeshError, Mode, Pose, Query, Tree, Workspace, shapes,
};

/// Where the parts of a file begin that has `vertices` f32 vertices and `triangles` triangles.
struct Places {
    vertices: usize,
    triangles: usize,
    order: usize,
    shapes: usize,
}

impl Places {
    fn of(tree: &Tree) -> Self {
        let vertices = 52;
        let triangles =
            vertices + tree.mesh().vertex_count() * if tree.mesh().is_f32() { 12 } else { 24 };
        let order = triangles + 12 * tree.mesh().len();
        Self {
            vertices,
            triangles,
            order,
            shapes: order + 4 * tree.mesh().len(),
        }
    }
}

/// Puts the right checksum at the end.
fn seal(bytes: &mut [u8]) {
    if let Some((content, checksum)) = bytes.split_last_chunk_mut::<4>() {
        *checksum = crc32fast::hash(content).to_le_bytes();
    }
}

/// A file made by hand: one byte a node, triangles in their order, no orientations.
fn file(mesh: &Mesh, shapes: &[u8]) -> Vec<u8> {
    let built = Tree::new(mesh.clone()).to_bytes();
    let places = Places::of(&Tree::new(mesh.clone()));
    let mut bytes = built[..places.order].to_vec();
    bytes.extend((0..mesh.len() as u32).flat_map(u32::to_le_bytes));
    bytes.extend_from_slice(shapes);
    bytes.extend_from_slice(&[0; 4]);
    bytes[32..40].copy_from_slice(&(shapes.len() as u64).to_le_bytes());
    bytes[40..48].copy_from_slice(&0u64.to_le_bytes());
    seal(&mut bytes);
    bytes
}

fn all_options() -> [BuildOptions; 3] {
    let mut axes = BuildOptions::default();
    axes.orientations = false;
    [
        BuildOptions::fast_build(),
        BuildOptions::default().extremes(true),
        axes,
    ]
}

/// All that a query says and leaves open, in every mode and order, whole and cut short.
fn answers(tree: &Tree, other: &Tree, pose: Pose) -> Vec<impl PartialEq + std::fmt::Debug> {
    let mut workspace = Workspace::new();
    let mut all = Vec::new();
    for mode in MODES {
        for order in ORDERS {
            for budget in [ENOUGH, punctual::Budget::work(3_000)] {
                let query = Query::intersection(tree, other, pose)
                    .mode(mode)
                    .order(order);
                let outcome = run(&query, &mut workspace, budget);
                let open: Vec<_> = query
                    .certificate(&workspace)
                    .iter()
                    .flat_map(Certificate::boxes)
                    .collect();
                all.push((outcome, workspace.pairs().to_vec(), open));
            }
        }
    }
    all
}

#[track_caller]
fn assert_same(loaded: &Tree, saved: &Tree, pose: Pose, other: &Tree) {
    assert_eq!(
        (loaded.mesh(), loaded.stats()),
        (saved.mesh(), saved.stats())
    );
    assert_eq!(loaded.degradation(), saved.degradation());
    assert_eq!(loaded.validate(), Ok(()));
    // Saved again, the bytes differ.
    assert!(loaded.to_bytes() == saved.to_bytes());
    assert_eq!(saved.bytes_len(), saved.to_bytes().len());
    assert_eq!(answers(loaded, other, pose), answers(saved, other, pose));
}

#[test]
fn a_loaded_tree_is_the_saved_one_to_the_bit() {
    let mut random = Random::new(71);
    for family in Family::ALL {
        for options in all_options() {
            for triangles in [0, 1, 7, 8, 9, 300] {
                let saved = Tree::with_options(soup(family, triangles, &mut random), &options);
                let other = Tree::new(soup(family, 60, &mut random));
                let loaded = Tree::from_bytes(&saved.to_bytes()).unwrap();
                let pose = pose_about(
                    family.center(),
                    0.5 * family.scale(),
                    Drift::Shear,
                    &mut random,
                );
                assert_same(&loaded, &saved, pose, &other);
            }
        }
    }
}

#[test]
fn shapes_and_refitted_trees_too() {
    let other = Tree::new(shapes::gear(11, 2));
    let mut random = Random::new(72);
    for mesh in [
        shapes::torus_knot(2, 3, 0.2, 24),
        shapes::cuboid(Vec3::ONE, 9),
        shapes::icosphere(3),
    ] {
        for options in all_options() {
            let mut tree = Tree::with_options(mesh.clone(), &options);
            let pose = pose_about(DVec3::ZERO, 0.3, Drift::None, &mut random);
            assert_same(
                &Tree::from_bytes(&tree.to_bytes()).unwrap(),
                &tree,
                pose,
                &other,
            );
            let moved: Vec<DVec3> = (0..mesh.vertex_count())
                .map(|i| mesh.vertex(i) + 0.1 * random.vector())
                .collect();
            tree.refit_f64(&moved).unwrap();
            assert!(tree.degradation() > 1.0);
            assert_same(
                &Tree::from_bytes(&tree.to_bytes()).unwrap(),
                &tree,
                pose,
                &other,
            );
        }
    }
}

/// Vertices that no triangle uses may hold anything, and keep it.
#[test]
fn unused_vertices_keep_every_bit() {
    let nan = f32::from_bits(0xffc1_2345);
    let mesh = Mesh::new(
        [[0.0; 3], [nan; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0, 2, 3]],
    )
    .unwrap();
    let bytes = Tree::new(mesh).to_bytes();
    assert!(Tree::from_bytes(&bytes).unwrap().to_bytes() == bytes);
}

#[test]
fn every_fault_is_named() {
    let tree = Tree::new(shapes::icosphere(2));
    let (good, places) = (tree.to_bytes(), Places::of(&tree));
    let changed = |place: usize, new: &[u8]| {
        let mut bytes = good.clone();
        bytes[place..place + new.len()].copy_from_slice(new);
        seal(&mut bytes);
        Tree::from_bytes(&bytes).map(drop).unwrap_err()
    };
    let triangle = |id| TreeFileError::Tree(TreeFault::Triangle(id));
    let children = |node| TreeFileError::Tree(TreeFault::Children(node));
    assert_eq!(changed(0, b"p"), TreeFileError::NotATree);
    assert_eq!(
        changed(8, &[0]),
        TreeFileError::Version {
            found: 0,
            supported: 3
        }
    );
    assert_eq!(changed(12, &[5]), TreeFileError::CoordinateSize(5));
    assert!(
        matches!(changed(48, &f32::NAN.to_le_bytes()), TreeFileError::Cost(cost) if cost.is_nan())
    );
    assert_eq!(
        changed(48, &(-1f32).to_le_bytes()),
        TreeFileError::Cost(-1.0)
    );
    let not_finite = MeshError::NotFinite { vertex: 5, axis: 1 };
    assert_eq!(
        changed(places.vertices + 5 * 12 + 4, &f32::NAN.to_le_bytes()),
        TreeFileError::Mesh(not_finite)
    );
    let no_vertex = MeshError::IndexOutOfRange {
        triangle: 3,
        corner: 2,
        index: 9999,
        vertices: 162,
    };
    assert_eq!(
        changed(places.triangles + 3 * 12 + 8, &9999u32.to_le_bytes()),
        TreeFileError::Mesh(no_vertex)
    );
    assert_eq!(changed(places.order, &320u32.to_le_bytes()), triangle(320));
    let second = u32::from_le_bytes(good[places.order + 4..][..4].try_into().unwrap());
    assert_eq!(
        changed(places.order, &second.to_le_bytes()),
        triangle(second)
    );
    for shape in [0, 1, 9, 16, 25, 64 + 8, 128 + 16 + 8] {
        assert_eq!(changed(places.shapes, &[shape]), children(0), "{shape}");
    }
    let root = good[places.shapes];
    assert!(matches!(
        changed(places.shapes, &[root ^ 32]),
        TreeFileError::Orientations { .. }
    ));
    let orientations = places.shapes + tree.stats().nodes;
    let bent = f32::from_le_bytes(good[orientations..][..4].try_into().unwrap()) + 1e-6;
    assert!(matches!(
        changed(orientations, &bent.to_le_bytes()),
        TreeFileError::Tree(TreeFault::Orientation(_))
    ));
    let mut damaged = good.clone();
    damaged[places.vertices] ^= 1;
    assert!(matches!(
        Tree::from_bytes(&damaged),
        Err(TreeFileError::Checksum { .. })
    ));
    for length in 0..good.len() {
        let expected = if length < 52 { 52 } else { good.len() as u128 };
        let error = Tree::from_bytes(&good[..length]).map(drop).unwrap_err();
        assert_eq!(
            error,
            TreeFileError::Length {
                expected,
                found: length
            }
        );
    }
    let huge = changed(16, &u64::MAX.to_le_bytes());
    assert!(
        matches!(huge, TreeFileError::Length { expected, .. } if expected > 1 << 64),
        "{huge}"
    );
}

/// A chain of inner nodes, each with seven leaves of one triangle and the rest below it: more nodes and levels for so many
/// triangles cannot be.
fn chain(inner: usize) -> Vec<u8> {
    let mut shapes = vec![8];
    for _ in 1..inner {
        shapes.extend([16 + 1; 7]);
        shapes.push(8);
    }
    shapes.extend([16 + 1; 7]);
    shapes.push(16 + 8);
    shapes
}

#[test]
fn the_deepest_chain_is_answered_and_a_deeper_one_refused() {
    let mut random = Random::new(73);
    for (inner, pose) in [
        (1, Pose::IDENTITY),
        (24, pose_about(DVec3::ZERO, 0.5, Drift::None, &mut random)),
    ] {
        let mesh = soup(Family::Uniform, 7 * inner + 8, &mut random);
        let tree = Tree::from_bytes(&file(&mesh, &chain(inner))).unwrap();
        assert_eq!((tree.stats().depth, tree.validate()), (inner + 1, Ok(())));
        assert_true(&tree, &tree, pose, &mut Workspace::new());
    }
    let mesh = soup(Family::Uniform, 7 * 25 + 8, &mut random);
    let error = Tree::from_bytes(&file(&mesh, &chain(25)))
        .map(drop)
        .unwrap_err();
    assert!(
        matches!(error, TreeFileError::Tree(TreeFault::Depth(_))),
        "{error}"
    );
}

/// No file makes the tree that is loaded take much more memory than the file.
#[test]
fn memory_is_in_proportion_to_the_bytes() {
    let corners = [[0.0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for inner in [1, 10, 24] {
        let mesh = Mesh::new(corners, vec![[0, 1, 2]; 7 * inner + 8]).unwrap();
        let bytes = file(&mesh, &chain(inner));
        let memory = Tree::from_bytes(&bytes).unwrap().stats().bytes();
        assert!(memory <= 44 * bytes.len(), "{memory} {}", bytes.len());
    }
    let refused = |shapes: &[u8], triangles: usize| {
        let mesh = soup(Family::Uniform, triangles, &mut Random::new(76));
        Tree::from_bytes(&file(&mesh, shapes))
            .map(drop)
            .unwrap_err()
    };
    let sparse = |node| TreeFileError::Tree(TreeFault::Sparse(node));
    // More nodes than 8 for 7 triangles: two children each, as many leaves as triangles.
    let pairs: Vec<u8> = [2]
        .into_iter()
        .chain([16 + 1, 2].repeat(30))
        .chain([16 + 1, 16 + 1])
        .collect();
    assert_eq!(refused(&pairs, 32), sparse(0));
    // Few nodes, but an inner one with too few triangles: a build makes a leaf of them.
    assert_eq!(refused(&[2, 16 + 4, 16 + 4], 8), sparse(0));
    assert_eq!(refused(&[2, 16 + 8, 2, 16 + 4, 16 + 4], 16), sparse(2));
    // One with room for more children, but an inner node among those that it has.
    assert_eq!(refused(&[2, 16 + 8, 2, 16 + 8, 16 + 8], 24), sparse(0));
    assert_eq!(
        refused(&[2, 16 + 8, 2, 16 + 8, 16 + 8], 24).to_string(),
        "the tree: node 0 has too few children or triangles"
    );
}

#[test]
fn nodes_that_are_not_reached_are_refused() {
    let mesh = soup(Family::Uniform, 8, &mut Random::new(74));
    // The root is a leaf; the others make up the numbers.
    for shapes in [&[16 + 4, 2, 16 + 4][..], &[16 + 6, 2, 16 + 2]] {
        let error = Tree::from_bytes(&file(&mesh, shapes))
            .map(drop)
            .unwrap_err();
        assert_eq!(error, TreeFileError::Tree(TreeFault::Children(1)));
    }
}

/// The tree says what all pairs of triangles of its mesh say.
#[track_caller]
fn assert_true(a: &Tree, b: &Tree, pose: Pose, workspace: &mut Workspace) {
    let truth = all_pairs(a.mesh(), b.mesh(), &pose);
    for mode in [Mode::Any, Mode::All] {
        let query = Query::intersection(a, b, pose).mode(mode);
        let (outcome, pairs) = run_to_end(&query, workspace, ENOUGH);
        assert_complete(mode, &outcome, &pairs, &truth);
    }
}

/// One to three changes at random; half of the results get the right checksum.
fn mutated(good: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = good[random.below(good.len())].clone();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len().max(1));
        let end = (at + 1 + random.below(24)).min(bytes.len());
        match random.below(10) {
            _ if bytes.is_empty() => bytes.push(0),
            0..=3 => bytes[at] ^= 1 << random.below(8),
            4 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)],
            5 => bytes[at..end].fill(random.bits() as u8),
            6 => {
                let to = random.below(bytes.len() + at + 1 - end);
                bytes.copy_within(at..end, to);
            }
            7 => bytes.truncate(at),
            8 => bytes.extend((0..random.below(40)).map(|i| i as u8)),
            _ => {
                // A piece of another tree.
                let other = &good[random.below(good.len())];
                let end = end.min(other.len());
                if at < end {
                    bytes[at..end].copy_from_slice(&other[at..end]);
                }
            }
        }
    }
    if random.below(2) == 0 {
        seal(&mut bytes);
    }
    bytes
}

#[test]
fn a_hundred_thousand_mutations_are_refused_or_answer_truly() {
    let mut random = Random::new(75);
    let meshes = [
        shapes::icosphere(1),
        shapes::cuboid(Vec3::new(1.0, 0.7, 0.4), 2),
        soup(Family::Double, 30, &mut random),
        soup(Family::Degenerate, 20, &mut random),
    ];
    let good: Vec<Vec<u8>> = meshes
        .iter()
        .map(|mesh| Tree::new(mesh.clone()).to_bytes())
        .collect();
    let other = Tree::new(shapes::icosphere(1));
    let mut workspace = Workspace::new();
    let (mut accepted, mut changed) = (0, 0);
    for _ in 0..100_000 {
        let bytes = mutated(&good, &mut random);
        let Ok(tree) = Tree::from_bytes(&bytes) else {
            continue;
        };
        accepted += 1;
        changed += usize::from(!good.contains(&bytes));
        let pose = pose_about(DVec3::ZERO, 0.8, Drift::None, &mut random);
        assert_true(&tree, &other, pose, &mut workspace);
    }
    assert!(changed > 10_000 && accepted < 50_000, "{changed}");
}
