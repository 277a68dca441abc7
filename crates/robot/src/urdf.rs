//! Robots from URDF and SRDF files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use punctual::Pose;
use punctual::glam::DVec3;
use punctual_io::xml::{self, Fault, Notices, Packages, attribute, child, line, number, numbers};
use roxmltree::Node;

use crate::error::refuse;
use crate::model::{Description, Joint, JointKind, Link, Mimic, Model, prefixed, sorted};
use crate::transform::{Transform, from_rpy, to_pose};
use crate::{RobotError, Shape};

/// Options for reading a URDF file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct UrdfOptions {
    /// The SRDF file. Its disabled pairs of links are not checked. Without a file, links that one
    /// moving joint joins are not checked.
    pub srdf: Option<PathBuf>,
    /// Folders in which packages are sought: `package://arm/hand.stl` is `FOLDER/arm/hand.stl`, or
    /// `FOLDER/hand.stl` if the folder is named `arm`. The folders above the URDF file follow. Then
    /// comes each folder whose `package.xml` has the name `arm`: up to five levels within these
    /// folders, and beside the URDF file and the folders above it.
    pub packages: Vec<PathBuf>,
    /// Meshes are solids ([`Shape::solid`]), not surfaces. Meshes with open edges stay surfaces,
    /// and [`Model::notices`] names them.
    pub solids: bool,
}

impl UrdfOptions {
    /// Sets the SRDF file.
    #[must_use]
    pub fn srdf(self, file: impl Into<PathBuf>) -> Self {
        let srdf = Some(file.into());
        Self { srdf, ..self }
    }

    /// Adds a folder of packages.
    #[must_use]
    pub fn packages(mut self, folder: impl Into<PathBuf>) -> Self {
        self.packages.push(folder.into());
        self
    }
}

impl Model {
    /// Reads a robot from a URDF file: the collision shapes, not the visual ones.
    ///
    /// A planar joint `base` becomes the joints `base/x`, `base/y` and `base/yaw`, about its axis;
    /// a floating one `base/x`, `base/y`, `base/z`, `base/yaw`, `base/pitch` and `base/roll`. Each
    /// turn is about an axis that the ones before have turned.
    ///
    /// # Errors
    /// [`RobotError::File`], which names the file, the line, and the link or joint: files that
    /// cannot be read, meshes of other formats than those of `punctual-io`, joints of an unknown
    /// type, and the errors of [`Model::new`].
    pub fn from_urdf(file: impl AsRef<Path>, options: &UrdfOptions) -> Result<Self, RobotError> {
        let file = file.as_ref();
        let mut meshes = Meshes {
            files: Packages::new(file.parent().unwrap_or(Path::new("")), &options.packages),
            are_solids: options.solids,
            read: HashMap::new(),
            notices: Notices::default(),
        };
        let mut description = parse(file, |root| robot(root, &mut meshes))?;
        description.allows_neighbours = options.srdf.is_none();
        let mut notices: Vec<String> = meshes.notices.of_file(file).collect();
        if let Some(srdf) = &options.srdf {
            let passed_over = parse(srdf, |root| allow(root, &mut description))?;
            notices.extend(passed_over.of_file(srdf));
        }
        let mut model = Self::new(&description).map_err(|error| error.within(file, None))?;
        model.notices = notices;
        Ok(model)
    }
}

/// Reads a file; errors name it.
fn parse<T>(
    file: &Path,
    make: impl FnOnce(Node<'_, '_>) -> Result<T, RobotError>,
) -> Result<T, RobotError> {
    let parsed = xml::read(file, |root| match root.has_tag_name("robot") {
        true => make(root),
        false => fail(root, "the outermost element is not `robot`"),
    });
    parsed.map_err(|error: RobotError| error.within(file, None))
}

/// A fault of a file, whose name is added where the file is read.
impl From<Fault> for RobotError {
    fn from(Fault { line, what, kind }: Fault) -> Self {
        let file = PathBuf::new();
        Self::File {
            file,
            line,
            what,
            kind,
        }
    }
}

impl RobotError {
    /// Turns the error into a fault of a file, on a line if it has none.
    fn within(mut self, place: &Path, at: Option<u32>) -> Self {
        if let Self::Model(what) = self {
            let (line, kind) = (None, None);
            self = Fault { line, what, kind }.into();
        }
        if let Self::File { file, line, .. } = &mut self {
            *file = place.to_owned();
            *line = line.or(at);
        }
        self
    }
}

/// An error at an element.
fn fail<T>(node: Node<'_, '_>, what: impl Into<String>) -> Result<T, RobotError> {
    Err(Fault::at(node, what).into())
}

/// Elements that are known to change no collision, by their parent.
const HARMLESS: [(&str, &str); 4] = [
    (
        "robot",
        "material transmission gazebo ros2_control sensor group group_state end_effector \
         virtual_joint passive_joint joint_property link_sphere_approximation",
    ),
    ("link", "inertial visual contact sensor"),
    (
        "joint",
        "dynamics calibration safety_controller hardwareInterface",
    ),
    ("collision", "material contact_coefficients"),
];

/// Notes elements of a parent, which is named, that are neither read nor harmless.
fn pass_over(notices: &mut Notices, parent: Node<'_, '_>, of: &str, read: &[&str]) {
    let place = parent.tag_name().name();
    let harmless = HARMLESS.iter().find(|(name, _)| *name == place);
    let harmless = harmless.map_or("", |(_, tags)| tags);
    let is_known = |tag: &str| read.contains(&tag) || harmless.split(' ').any(|it| it == tag);
    notices.pass_over(parent, of, is_known);
}

fn robot(root: Node<'_, '_>, meshes: &mut Meshes<'_>) -> Result<Description, RobotError> {
    let is_macro = |node: &Node<'_, '_>| {
        let space = node.tag_name().namespace();
        space.is_some_and(|space| space.contains("xacro"))
    };
    if let Some(node) = root.descendants().find(is_macro) {
        return fail(node, "a xacro file; `xacro FILE` expands it to URDF");
    }
    let mut robot = Description {
        name: root.attribute("name").unwrap_or("").to_owned(),
        ..Description::default()
    };
    pass_over(&mut meshes.notices, root, "", &["link", "joint"]);
    for node in root.children() {
        let tag = node.tag_name().name();
        let name = node.attribute("name").unwrap_or("without a name");
        let of = |error| prefixed(&format!("{tag} {name}"), error);
        match tag {
            "link" => robot.links.push(link(node, meshes).map_err(of)?),
            "joint" => {
                let read = ["parent", "child", "origin", "axis", "limit", "mimic"];
                let place = format!("joint {name}: ");
                pass_over(&mut meshes.notices, node, &place, &read);
                let joint = joint(node).map_err(of)?;
                match free_axes(node.attribute("type"), joint.axis.into()) {
                    None => robot.joints.push(joint),
                    Some(axes) => free(&mut robot, joint, &axes),
                }
            }
            _ => {}
        }
    }
    Ok(robot)
}

fn link(node: Node<'_, '_>, meshes: &mut Meshes<'_>) -> Result<Link, RobotError> {
    let mut shapes = Vec::new();
    let name = attribute(node, "name")?.to_owned();
    let place = format!("link {name}: ");
    pass_over(&mut meshes.notices, node, &place, &["collision"]);
    let is_collision = |node: &Node<'_, '_>| node.has_tag_name("collision");
    for collision in node.children().filter(is_collision) {
        let read = ["origin", "geometry"];
        pass_over(&mut meshes.notices, collision, &place, &read);
        let geometry = child(collision, "geometry").and_then(|node| node.first_element_child());
        let Some(geometry) = geometry else {
            return fail(collision, "a collision without geometry");
        };
        if geometry.next_sibling_element().is_some() {
            return fail(geometry, "a geometry of several shapes, must be one");
        }
        let shape = shape(geometry, meshes)
            .map_err(|error| error.within(Path::new(""), Some(line(geometry))))?;
        shapes.push((to_pose(&origin(collision)?), shape));
    }
    Ok(Link { name, shapes })
}

fn shape(node: Node<'_, '_>, meshes: &mut Meshes<'_>) -> Result<Shape, RobotError> {
    let of = |name| number(node, name, None);
    match node.tag_name().name() {
        "box" => Shape::cuboid(numbers(node, "size", None)?),
        "sphere" => Shape::sphere(of("radius")?),
        "cylinder" => Shape::cylinder(of("radius")?, of("length")?),
        "capsule" => Shape::capsule(of("radius")?, of("length")?),
        "mesh" => {
            let scale = numbers(node, "scale", Some([1.0; 3]))?;
            meshes.shape(node, attribute(node, "filename")?, scale)
        }
        other => refuse(format!(
            "a shape of the kind `{other}`, known are box, sphere, cylinder, capsule and mesh"
        )),
    }
}

/// The axes of a joint that is planar or floating, each with the end of its name.
fn free_axes(kind: Option<&str>, axis: DVec3) -> Option<Vec<(&'static str, DVec3)>> {
    let [x, y, z] = DVec3::AXES;
    match kind? {
        "planar" => {
            let axis = axis.normalize_or(DVec3::Z);
            let (x, y) = axis.any_orthonormal_pair();
            Some(vec![("x", x), ("y", y), ("yaw", axis)])
        }
        "floating" => {
            let slides = [("x", x), ("y", y), ("z", z)];
            let turns = [("yaw", z), ("pitch", y), ("roll", x)];
            Some([slides, turns].concat())
        }
        _ => None,
    }
}

/// Adds a joint of several axes as a chain of joints, with links without shapes between them.
fn free(robot: &mut Description, joint: Joint, axes: &[(&str, DVec3)]) {
    let name = |axis: &str| format!("{}/{axis}", joint.name);
    let (mut parent, mut origin) = (joint.parent.clone(), joint.origin);
    for (i, &(axis, along)) in axes.iter().enumerate() {
        let child = axes.get(i + 1).map_or(joint.child.clone(), |_| name(axis));
        let kinds = [JointKind::Continuous, JointKind::Prismatic];
        robot.joints.push(Joint {
            name: name(axis),
            kind: kinds[usize::from(axis.len() == 1)],
            parent: std::mem::replace(&mut parent, child.clone()),
            child,
            origin: std::mem::replace(&mut origin, Pose::IDENTITY),
            axis: along.to_array(),
            limits: None,
            mimic: None,
        });
    }
    for pair in axes.windows(2) {
        let (name, shapes) = (name(pair[0].0), Vec::new());
        robot.links.push(Link { name, shapes });
    }
}

fn joint(node: Node<'_, '_>) -> Result<Joint, RobotError> {
    let kind = match attribute(node, "type")? {
        "fixed" | "planar" | "floating" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        other => {
            let known = "known are fixed, revolute, continuous, prismatic, planar and floating";
            return fail(node, format!("of the type `{other}`, {known}"));
        }
    };
    let link = |which: &str| match child(node, which) {
        Some(node) => Ok(attribute(node, "link")?.to_owned()),
        None => fail(node, format!("no {which}")),
    };
    let axis = child(node, "axis").map(|node| numbers(node, "xyz", Some([1.0, 0.0, 0.0])));
    let limits = child(node, "limit").filter(|_| kind != JointKind::Continuous);
    let limits = limits.map(|node| {
        let lower = number(node, "lower", Some(0.0))?;
        Ok::<_, Fault>([lower, number(node, "upper", Some(0.0))?])
    });
    let mimic = child(node, "mimic").map(|node| {
        Ok::<_, Fault>(Mimic {
            joint: attribute(node, "joint")?.to_owned(),
            multiplier: number(node, "multiplier", Some(1.0))?,
            offset: number(node, "offset", Some(0.0))?,
        })
    });
    Ok(Joint {
        name: attribute(node, "name")?.to_owned(),
        kind,
        parent: link("parent")?,
        child: link("child")?,
        origin: to_pose(&origin(node)?),
        axis: axis.unwrap_or(Ok([1.0, 0.0, 0.0]))?,
        limits: limits.transpose()?,
        mimic: mimic.transpose()?,
    })
}

fn origin(node: Node<'_, '_>) -> Result<Transform, RobotError> {
    let Some(node) = child(node, "origin") else {
        return Ok(Transform::IDENTITY);
    };
    let rpy = numbers(node, "rpy", Some([0.0; 3]))?;
    let xyz = numbers(node, "xyz", Some([0.0; 3]))?;
    Ok(from_rpy(rpy, xyz))
}

/// The mesh files of a robot. Each is read once for each scale.
struct Meshes<'o> {
    files: Packages<'o>,
    are_solids: bool,
    read: HashMap<(PathBuf, [u64; 3]), Shape>,
    notices: Notices,
}

impl Meshes<'_> {
    fn shape(
        &mut self,
        node: Node<'_, '_>,
        name: &str,
        scale: [f64; 3],
    ) -> Result<Shape, RobotError> {
        let key = (self.files.find(name)?, scale.map(f64::to_bits));
        if let Some(shape) = self.read.get(&key) {
            return Ok(shape.clone());
        }
        let loaded = punctual_io::load(&key.0).map_err(|error| {
            let (line, what, kind) = (None, error.to_string(), error.kind());
            Fault { line, what, kind }
        })?;
        let mesh = loaded.mesh.scaled_by(scale);
        let mesh = mesh.or_else(|error| refuse(format!("mesh {name}: {error}")))?;
        let shape = [Shape::mesh, Shape::solid][usize::from(self.are_solids)](mesh);
        let solid = shape.surface().solid();
        if let Some(solid) = solid.filter(|solid| !solid.is_closed()) {
            let why = format!("it has {} open edges", solid.open_edges());
            let notice = format!("mesh {}: a surface, for {why}", key.0.display());
            self.notices.add(node, notice);
        }
        self.read.insert(key, shape.clone());
        Ok(shape)
    }
}

/// Adds the disabled pairs of an SRDF file. Notices tell of links that the robot does not have.
fn allow(root: Node<'_, '_>, robot: &mut Description) -> Result<Notices, RobotError> {
    let (mut notices, mut enabled) = (Notices::default(), Vec::new());
    let read = [
        "disable_collisions",
        "enable_collisions",
        "disable_default_collisions",
    ];
    pass_over(&mut notices, root, "", &read);
    for node in root.children() {
        let keys: &[&str] = match node.tag_name().name() {
            "disable_collisions" | "enable_collisions" => &["link1", "link2"],
            "disable_default_collisions" => &["link"],
            _ => continue,
        };
        let links = keys.iter().map(|key| attribute(node, key));
        let links = links.collect::<Result<Vec<_>, _>>()?;
        let known = |name: &str| robot.links.iter().any(|link| link.name == name);
        if let Some(name) = links.iter().find(|name| !known(name)) {
            notices.add(node, format!("there is no link {name}"));
            continue;
        }
        let others = robot.links.iter().map(|link| link.name.clone());
        match (node.tag_name().name(), &links[..]) {
            ("enable_collisions", &[a, b]) => enabled.push(sorted([a.to_owned(), b.to_owned()])),
            (_, &[a, b]) => robot.allowed.push([a.to_owned(), b.to_owned()]),
            (_, names) => {
                let pairs = others.map(|other| [names[0].to_owned(), other]);
                robot.allowed.extend(pairs);
            }
        }
    }
    let is_off = |pair: &[String; 2]| !enabled.contains(&sorted(pair.clone()));
    robot.allowed.retain(is_off);
    Ok(notices)
}
