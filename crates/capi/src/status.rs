//! How a call ends: a status, and a text for people.

use crate::verbs::types;
use ::punctual_robot::RobotError;
use ::punctual_scene::SceneError;
use core::cell::RefCell;
use core::ffi::c_char;
use core::fmt::{self, Write};
use punctual::geom::{MotionError, RayError};
use punctual::points::PointError;
use punctual::tree::{ShapeError, SolidError, TreeFault, TreeFileError};
use punctual::{DepthError, MeshError, PoseError, ResumeError};
use punctual_io::{FileError, ReadError};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

types! {
    /// How a call ended. Unless it is `PUNCTUAL_STATUS_OK`, nothing was written to the outputs and
    /// nothing was changed (but see `PUNCTUAL_STATUS_PANIC`), and `punctual_last_error` has a text
    /// that names the place.
    enum punctual_status {
        /// Done.
        Ok = 0,
        /// A pointer that must not be null is null.
        Null = 1,
        /// A number is out of its range: an unknown value of an enumeration, an index or a length,
        /// or NaN.
        BadArgument = 2,
        /// Vertices and triangles are no mesh, or new vertices do not fit it.
        BadMesh = 3,
        /// Numbers are no pose: not finite, no rotation, or too far out.
        BadPose = 4,
        /// A body id is not valid in this scene.
        NoSuchBody = 5,
        /// The scene has no id left.
        SceneFull = 6,
        /// The workspace does not hold a run of this query: same trees, pose and options.
        NotResumable = 7,
        /// A tree is unsound. None that was built here is.
        BadTree = 8,
        /// There is not that much memory.
        OutOfMemory = 9,
        /// The operating system gives no thread.
        NoThread = 10,
        /// An earlier call ended with `PUNCTUAL_STATUS_PANIC` while it changed this handle, which
        /// can only be freed now.
        Poisoned = 11,
        /// A fault of the library was caught. The handles that the call was to change are poisoned.
        Panic = 12,
        /// A file cannot be read, or it, or its bytes, hold no mesh or no tree, or are damaged.
        BadFile = 13,
    }
}

/// What keeps a call from its work.
#[derive(Debug)]
pub(crate) enum Fault {
    Null(&'static str),
    /// An array that would not fit into memory, or starts at an odd address.
    Array(&'static str),
    /// The size of a struct, or of one element of an array.
    Size(&'static str, usize),
    /// A struct of a newer header asks for what is not known.
    Newer(&'static str),
    /// Numbers that no calibration has.
    Calibration,
    /// An unknown value of an enumeration.
    Value(&'static str, u32),
    /// An index, and how many there are.
    Index(&'static str, usize, usize),
    /// A number, and the largest that is possible.
    TooMany(&'static str, usize, usize),
    /// Not finite, or larger than allowed.
    Number(&'static str, f64),
    /// Below 0, or NaN.
    Negative(&'static str, f64),
    NotUtf8(&'static str),
    OutOfMemory,
    Poisoned(&'static str),
    Mesh(MeshError),
    Pose(PoseError),
    Motion(MotionError),
    /// Of an array, which one.
    Ray(&'static str, Option<usize>, RayError),
    Scene(SceneError),
    Resume(ResumeError),
    Tree(TreeFault),
    TreeFile(TreeFileError),
    MeshFile(FileError),
    MeshBytes(ReadError),
    Thread(io::Error),
    Points(PointError),
    Robot(RobotError),
    Solid(SolidError),
    Shape(ShapeError),
    Depth(DepthError),
}

impl Fault {
    fn status(&self) -> punctual_status {
        match self {
            Self::Null(_) => punctual_status::Null,
            Self::Array(_)
            | Self::Size(..)
            | Self::Newer(_)
            | Self::Calibration
            | Self::Value(..)
            | Self::Index(..)
            | Self::TooMany(..)
            | Self::Number(..)
            | Self::Negative(..)
            | Self::Ray(..)
            | Self::Points(_)
            | Self::Depth(_)
            | Self::NotUtf8(_) => punctual_status::BadArgument,
            Self::OutOfMemory => punctual_status::OutOfMemory,
            Self::Poisoned(_) => punctual_status::Poisoned,
            Self::Shape(ShapeError::Length { .. } | ShapeError::Columns { .. }) => {
                punctual_status::BadArgument
            }
            Self::Mesh(_) | Self::Solid(_) | Self::Shape(_) => punctual_status::BadMesh,
            Self::Pose(_) => punctual_status::BadPose,
            Self::Scene(SceneError::NoSuchBody { .. }) => punctual_status::NoSuchBody,
            Self::Scene(SceneError::NotARotation { .. } | SceneError::TooFar { .. }) => {
                punctual_status::BadPose
            }
            Self::Scene(SceneError::Full) => punctual_status::SceneFull,
            // What may be added to them is an argument that the scene refuses.
            Self::Scene(_) | Self::Motion(_) => punctual_status::BadArgument,
            Self::Resume(_) => punctual_status::NotResumable,
            Self::Tree(_) => punctual_status::BadTree,
            Self::TreeFile(_) | Self::MeshFile(_) | Self::MeshBytes(_) => punctual_status::BadFile,
            Self::Thread(_) => punctual_status::NoThread,
            Self::Robot(RobotError::File { .. }) => punctual_status::BadFile,
            Self::Robot(RobotError::NothingToResume) => punctual_status::NotResumable,
            Self::Robot(_) => punctual_status::BadArgument,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(what) => write!(f, "{what} is null"),
            Self::Array(what) => write!(f, "{what} is longer than memory or not aligned"),
            Self::Size(what, size) => {
                write!(
                    f,
                    "the size of {what} is given as {size}: it has to be its sizeof"
                )
            }
            Self::Newer(what) => {
                write!(
                    f,
                    "{what} has a field set that this library, {}, does not have",
                    env!("CARGO_PKG_VERSION")
                )
            }
            Self::Calibration => f.write_str("calibration has numbers that cannot be learned"),
            Self::Value(what, value) => write!(f, "{what} has no value {value}"),
            Self::Index(what, index, count) => {
                write!(f, "{what} is {index}, but there are {count}")
            }
            Self::TooMany(what, value, most) => write!(f, "{what} is {value}, possible are {most}"),
            Self::Number(what, value) => {
                write!(f, "{what} is {value}, which is not finite or too large")
            }
            Self::Negative(what, value) => {
                write!(f, "{what} is {value}, which is negative or no number")
            }
            Self::NotUtf8(what) => write!(f, "{what} is not UTF-8"),
            Self::OutOfMemory => f.write_str("there is not that much memory"),
            Self::Poisoned(what) => write!(
                f,
                "{what} was being changed when a fault was caught; it can only be freed"
            ),
            Self::Mesh(error) => error.fmt(f),
            Self::Pose(error) => error.fmt(f),
            Self::Motion(error) => error.fmt(f),
            Self::Ray(what, Some(index), error) => write!(f, "{what}[{index}]: {error}"),
            Self::Ray(what, None, error) => write!(f, "{what}: {error}"),
            Self::Scene(error) => error.fmt(f),
            Self::Resume(error) => error.fmt(f),
            Self::Tree(error) => error.fmt(f),
            Self::TreeFile(error) => error.fmt(f),
            Self::MeshFile(error) => error.fmt(f),
            Self::MeshBytes(error) => error.fmt(f),
            Self::Thread(error) => error.fmt(f),
            Self::Points(PointError::NotSolid) => f.write_str(
                "the tree was not built as a solid, see `solid` of punctual_build_options",
            ),
            Self::Points(PointError::NotCloud) => f.write_str(
                "the tree is not that of a point cloud, see punctual_tree_from_points_f32",
            ),
            Self::Points(error) => error.fmt(f),
            Self::Robot(error) => error.fmt(f),
            Self::Solid(error) => error.fmt(f),
            Self::Shape(error) => error.fmt(f),
            Self::Depth(error) => error.fmt(f),
        }
    }
}

macro_rules! fault_from {
    ($($variant:ident($error:ty)),*) => {
        $(impl From<$error> for Fault {
            fn from(error: $error) -> Self {
                Self::$variant(error)
            }
        })*
    };
}

fault_from!(
    Mesh(MeshError),
    Pose(PoseError),
    Motion(MotionError),
    Scene(SceneError),
    Resume(ResumeError),
    Tree(TreeFault),
    TreeFile(TreeFileError),
    MeshFile(FileError),
    MeshBytes(ReadError),
    Thread(io::Error),
    Points(PointError),
    Robot(RobotError),
    Solid(SolidError),
    Shape(ShapeError),
    Depth(DepthError)
);

/// Runs the work of the call `name`. No panic leaves it.
pub(crate) fn door(
    name: &'static str,
    work: impl FnOnce() -> Result<(), Fault>,
) -> punctual_status {
    // What a panic leaves half done is poisoned: `Handle::change`.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => punctual_status::Ok,
        Ok(Err(fault)) => {
            note(format_args!("{name}: {fault}"));
            fault.status()
        }
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().copied();
            let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
            note(format_args!(
                "{name}: caught a fault of the library: {}",
                text.unwrap_or("no text")
            ));
            punctual_status::Panic
        }
    }
}

/// The pointer, unless it is null.
pub(crate) fn given<P>(pointer: Option<P>, what: &'static str) -> Result<P, Fault> {
    pointer.ok_or(Fault::Null(what))
}

/// The value of an enumeration that C passes as a number; all of them, in the order of their
/// numbers.
pub(crate) fn value_of<T: Copy>(number: u32, what: &'static str, all: &[T]) -> Result<T, Fault> {
    all.get(number as usize)
        .copied()
        .ok_or(Fault::Value(what, number))
}

/// Frees a handle.
pub(crate) fn free<T>(handle: Option<Box<T>>) {
    let _ = catch_unwind(AssertUnwindSafe(|| drop(handle)));
}

/// A text that ends with a zero byte and is cut where its room ends, so that noting it needs no
/// allocation.
#[repr(C)]
struct Text {
    bytes: [u8; 256],
    len: usize,
}

impl Text {
    const EMPTY: Self = Self {
        bytes: [0; 256],
        len: 0,
    };
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let mut utf8 = [0; 4];
            let utf8 = character.encode_utf8(&mut utf8).as_bytes();
            let end = self.len + utf8.len();
            if end >= self.bytes.len() {
                return Err(fmt::Error);
            }
            self.bytes[self.len..end].copy_from_slice(utf8);
            self.len = end;
        }
        Ok(())
    }
}

thread_local! {
    static LAST: RefCell<Text> = const { RefCell::new(Text::EMPTY) };
}

fn note(text: fmt::Arguments<'_>) {
    LAST.with_borrow_mut(|last| {
        *last = Text::EMPTY;
        // Of a text that is too long, the beginning has the place.
        let _ = last.write_fmt(text);
    });
}

/// The text of the last call on this thread that failed, in UTF-8: the function, the place and the
/// fault. Empty if none did. Valid until the next call on this thread that fails; calls that
/// succeed leave it.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_last_error() -> *const c_char {
    LAST.with(|last| last.as_ptr()).cast_const().cast()
}

/// The version of the library, such as "1.2.3". Compare it with `PUNCTUAL_VERSION`, that of the
/// header.
#[unsafe(no_mangle)]
pub extern "C" fn punctual_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handle::Handle;
    use core::ffi::CStr;

    fn last_error() -> String {
        // SAFETY: the text ends with a zero byte, and no other call fails on this thread meanwhile.
        unsafe { CStr::from_ptr(punctual_last_error()) }
            .to_str()
            .unwrap()
            .into()
    }

    #[test]
    fn a_panic_becomes_a_status_and_poisons_the_handle() {
        let mut handle = Handle::new(1);
        let status = door("punctual_test", || {
            handle.change("it", |value| {
                *value = 2;
                panic!("half {}", "way")
            })
        });
        assert_eq!(status, punctual_status::Panic);
        assert_eq!(
            last_error(),
            "punctual_test: caught a fault of the library: half way"
        );
        for again in [
            door("again", || handle.change("it", |_| Ok(()))),
            door("again", || handle.get("it").map(drop)),
        ] {
            assert_eq!(again, punctual_status::Poisoned);
            assert_eq!(
                last_error(),
                "again: it was being changed when a fault was caught; it can only be freed"
            );
        }
    }

    #[test]
    fn a_fault_leaves_the_handle_in_use() {
        let mut handle = Handle::new(1);
        let status = door("first", || {
            handle.change("it", |_| Err::<(), _>(Fault::Null("x")))
        });
        assert_eq!(
            (status, last_error().as_str()),
            (punctual_status::Null, "first: x is null")
        );
        assert_eq!(
            door("second", || handle.change("it", |_| Ok(()))),
            punctual_status::Ok
        );
        assert_eq!(last_error(), "first: x is null");
    }

    #[test]
    fn a_long_text_is_cut_between_characters() {
        note(format_args!("{}", "ä".repeat(300)));
        assert_eq!(last_error(), "ä".repeat(127));
    }
}
