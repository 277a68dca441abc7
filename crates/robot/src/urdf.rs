//! Robots from URDF and SRDF files.

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use punctual::Pose;
use punctual::glam::DVec3;
use punctual_io::text::{decode, without_late_declaration};
use roxmltree::{Document, Node};

use crate::error::refuse;
use crate::model::{Description, Joint, JointKind, LARGEST, Link, Mimic, Model, prefixed, sorted};
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
            folder: file.parent().unwrap_or(Path::new("")),
            options,
            read: HashMap::new(),
            packages: HashMap::new(),
            notices: Notices::default(),
        };
        let mut description = parse(file, |root| robot(root, &mut meshes))?;
        description.allows_neighbours = options.srdf.is_none();
        let mut notices: Vec<String> = meshes.notices.of_file(file).collect();
        if let Some(srdf) = &options.srdf {
            let passed_over = parse(srdf, |root| allow(root, &mut description))?;
            notices.extend(passed_over.of_file(srdf));
        }
        let mut model = Self::new(&description).map_err(|error| error.within(file))?;
        model.notices = notices;
        Ok(model)
    }
}

/// Reads a file; errors name it.
fn parse<T>(
    file: &Path,
    read: impl FnOnce(Node<'_, '_>) -> Result<T, RobotError>,
) -> Result<T, RobotError> {
    let parsed = || {
        let bytes = fs::read(file).map_err(|error| {
            let (what, kind) = (error.to_string(), Some(error.kind()));
            fault(None, what, kind)
        })?;
        let text = decode(&bytes);
        let text = without_late_declaration(&text);
        let document = Document::parse(&text)
            .map_err(|error| fault(Some(error.pos().row), error.to_string(), None))?;
        let root = document.root_element();
        if root.has_tag_name("robot") {
            read(root)
        } else {
            fail(root, "the outermost element is not `robot`")
        }
    };
    parsed().map_err(|error| error.within(file))
}

fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// An error in a file, whose name [`parse`] adds.
fn fault(line: Option<u32>, what: String, kind: Option<io::ErrorKind>) -> RobotError {
    RobotError::File {
        file: PathBuf::new(),
        line,
        what,
        kind,
    }
}

/// An error at an element.
fn fail<T>(node: Node<'_, '_>, what: impl Into<String>) -> Result<T, RobotError> {
    Err(fault(Some(line(node)), what.into(), None))
}

/// Elements that are known to change no collision, by their parent.
const HARMLESS: [(&str, &[&str]); 5] = [
    (
        "robot",
        &[
            "material",
            "transmission",
            "gazebo",
            "ros2_control",
            "sensor",
            // SRDF
            "group",
            "group_state",
            "end_effector",
            "virtual_joint",
            "passive_joint",
            "joint_property",
            "link_sphere_approximation",
        ],
    ),
    ("link", &["inertial", "visual", "contact", "sensor"]),
    (
        "joint",
        &[
            "dynamics",
            "calibration",
            "safety_controller",
            "hardwareInterface",
        ],
    ),
    ("collision", &["material", "contact_coefficients"]),
    ("geometry", &[]),
];

/// The elements that were passed over, with their lines.
#[derive(Default)]
struct Notices(Vec<(u32, String)>);

impl Notices {
    fn add(&mut self, node: Node<'_, '_>, what: String) {
        self.0.push((line(node), what));
    }

    /// Notes elements that are neither read nor harmless, the first of each kind. `of` names their
    /// parent.
    fn pass_over(&mut self, parent: Node<'_, '_>, of: &str, read: &[&str]) {
        let place = parent.tag_name().name();
        let harmless = HARMLESS.iter().find(|(name, _)| *name == place);
        let is_known = |tag: &str| {
            read.contains(&tag) || harmless.is_some_and(|(_, tags)| tags.contains(&tag))
        };
        for node in parent.children().filter(Node::is_element) {
            let tag = node.tag_name().name();
            let what = format!("`{tag}` in a `{place}` is passed over");
            if !is_known(tag) && !self.0.iter().any(|(_, told)| told.ends_with(&what)) {
                self.add(node, format!("{of}{what}"));
            }
        }
    }

    fn of_file(self, file: &Path) -> impl Iterator<Item = String> {
        let told = |(line, what)| format!("{}:{line}: {what}", file.display());
        self.0.into_iter().map(told)
    }
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
    meshes.notices.pass_over(root, "", &["link", "joint"]);
    for node in root.children() {
        let tag = node.tag_name().name();
        let name = node.attribute("name").unwrap_or("without a name");
        let of = |error| prefixed(&format!("{tag} {name}"), error);
        match tag {
            "link" => robot.links.push(link(node, meshes).map_err(of)?),
            "joint" => {
                let read = ["parent", "child", "origin", "axis", "limit", "mimic"];
                let place = format!("joint {name}: ");
                meshes.notices.pass_over(node, &place, &read);
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
    meshes.notices.pass_over(node, &place, &["collision"]);
    let is_collision = |node: &Node<'_, '_>| node.has_tag_name("collision");
    for collision in node.children().filter(is_collision) {
        let read = ["origin", "geometry"];
        meshes.notices.pass_over(collision, &place, &read);
        let geometry = child(collision, "geometry").and_then(|node| node.first_element_child());
        let Some(geometry) = geometry else {
            return fail(collision, "a collision without geometry");
        };
        if geometry.next_sibling_element().is_some() {
            return fail(geometry, "a geometry of several shapes, must be one");
        }
        let shape = shape(geometry, meshes).map_err(|error| match error {
            RobotError::Model(what) => fault(Some(line(geometry)), what, None),
            RobotError::File {
                line: None,
                what,
                kind,
                ..
            } => fault(Some(line(geometry)), what, kind),
            error => error,
        })?;
        shapes.push((to_pose(&origin(collision)?), shape));
    }
    Ok(Link { name, shapes })
}

fn shape(node: Node<'_, '_>, meshes: &mut Meshes<'_>) -> Result<Shape, RobotError> {
    match node.tag_name().name() {
        "box" => Shape::cuboid(numbers(node, "size", None)?),
        "sphere" => Shape::sphere(number(node, "radius", None)?),
        "cylinder" => {
            let radius = number(node, "radius", None)?;
            Shape::cylinder(radius, number(node, "length", None)?)
        }
        "capsule" => {
            let radius = number(node, "radius", None)?;
            Shape::capsule(radius, number(node, "length", None)?)
        }
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
    let mut parent = joint.parent;
    for (i, (axis, along)) in axes.iter().enumerate() {
        let name = format!("{}/{axis}", joint.name);
        let child = if i + 1 == axes.len() {
            joint.child.clone()
        } else {
            robot.links.push(Link {
                name: name.clone(),
                shapes: Vec::new(),
            });
            name.clone()
        };
        robot.joints.push(Joint {
            name,
            kind: if axis.len() == 1 {
                JointKind::Prismatic
            } else {
                JointKind::Continuous
            },
            parent: std::mem::replace(&mut parent, child.clone()),
            child,
            origin: if i == 0 { joint.origin } else { Pose::IDENTITY },
            axis: along.to_array(),
            limits: None,
            mimic: None,
        });
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
        Ok([lower, number(node, "upper", Some(0.0))?])
    });
    let mimic = child(node, "mimic").map(|node| {
        Ok(Mimic {
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

fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|node| node.has_tag_name(name))
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, RobotError> {
    match node.attribute(name) {
        Some(text) => Ok(text.trim()),
        None => {
            let tag = node.tag_name().name();
            fail(node, format!("`{tag}` without `{name}`"))
        }
    }
}

fn number(node: Node<'_, '_>, name: &str, missing: Option<f64>) -> Result<f64, RobotError> {
    numbers(node, name, missing.map(|number| [number])).map(|[number]| number)
}

/// The numbers of an attribute, or their defaults if it is missing.
fn numbers<const N: usize>(
    node: Node<'_, '_>,
    name: &str,
    missing: Option<[f64; N]>,
) -> Result<[f64; N], RobotError> {
    if let (None, Some(missing)) = (node.attribute(name), missing) {
        return Ok(missing);
    }
    let text = attribute(node, name)?;
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    match numbers.filter(|numbers: &[f64; N]| numbers.iter().all(|x| x.abs() <= LARGEST)) {
        Some(numbers) => Ok(numbers),
        None => {
            let must = format!("must be {N} numbers of at most {LARGEST:e}");
            fail(node, format!("`{name}` is \"{text}\", {must}"))
        }
    }
}

/// The mesh files of a robot. Each is read once for each scale.
struct Meshes<'o> {
    folder: &'o Path,
    options: &'o UrdfOptions,
    read: HashMap<(PathBuf, [u64; 3]), Shape>,
    /// The folders of packages that were sought by their `package.xml`.
    packages: HashMap<String, Vec<PathBuf>>,
    notices: Notices,
}

impl Meshes<'_> {
    fn shape(
        &mut self,
        node: Node<'_, '_>,
        name: &str,
        scale: [f64; 3],
    ) -> Result<Shape, RobotError> {
        let key = (self.find(name)?, scale.map(f64::to_bits));
        if let Some(shape) = self.read.get(&key) {
            return Ok(shape.clone());
        }
        let loaded = punctual_io::load(&key.0)
            .map_err(|error| fault(None, error.to_string(), error.kind()))?;
        let mesh = loaded.mesh.scaled_by(scale);
        let mesh = mesh.or_else(|error| refuse(format!("mesh {name}: {error}")))?;
        let shape = if self.options.solids {
            Shape::solid(mesh)
        } else {
            Shape::mesh(mesh)
        };
        let solid = shape.surface().solid();
        if let Some(solid) = solid.filter(|solid| !solid.is_closed()) {
            let why = format!("it has {} open edges", solid.open_edges());
            let notice = format!("mesh {}: a surface, for {why}", key.0.display());
            self.notices.add(node, notice);
        }
        self.read.insert(key, shape.clone());
        Ok(shape)
    }

    /// The file of a name, which may be a URL.
    fn find(&mut self, name: &str) -> Result<PathBuf, RobotError> {
        let mut kinds = ["package://", "model://"].iter();
        let Some(path) = kinds.find_map(|kind| name.strip_prefix(kind)) else {
            let path = name.strip_prefix("file://").unwrap_or(name);
            return Ok(self.folder.join(path));
        };
        let (package, rest) = path.split_once('/').unwrap_or(("", path));
        let folder = fs::canonicalize(self.folder).unwrap_or(self.folder.to_owned());
        let packages = self.options.packages.iter().map(PathBuf::as_path);
        let path = path.trim_start_matches('/');
        for folder in packages.chain(folder.ancestors()) {
            let is_package = folder.file_name().is_some_and(|name| name == package);
            let within = is_package.then(|| folder.join(rest));
            let mut files = [folder.join(path)].into_iter().chain(within);
            if let Some(file) = files.find(|file| file.is_file()) {
                return Ok(file);
            }
        }
        let named = self.packages.entry(package.to_owned()).or_insert_with(|| {
            let mut found = Vec::new();
            for folder in &self.options.packages {
                add_packages(package, folder, DEEPEST, &mut found);
            }
            for folder in folder.ancestors() {
                add_packages(package, folder, 1, &mut found);
            }
            found
        });
        let mut files = named.iter().map(|folder| folder.join(rest));
        files.find(|file| file.is_file()).ok_or_else(|| {
            let sought = "not found in the package folders, nor in those above the URDF file";
            let what = format!("mesh {name}: {sought}, by folder or package.xml");
            fault(None, what, Some(io::ErrorKind::NotFound))
        })
    }
}

/// Levels of folders in which packages are sought by their `package.xml`.
const DEEPEST: usize = 5;

/// Adds the folders whose `package.xml` has this name, down to some levels below a folder. As in
/// ROS, there are no packages within packages.
fn add_packages(package: &str, folder: &Path, levels: usize, found: &mut Vec<PathBuf>) {
    if let Ok(bytes) = fs::read(folder.join("package.xml")) {
        let text = decode(&bytes);
        let text = without_late_declaration(&text);
        let document = Document::parse(&text);
        let name = document.as_ref().ok().and_then(|document| {
            let name = child(document.root_element(), "name")?;
            name.text()
        });
        if name.is_some_and(|name| name.trim() == package) {
            found.push(folder.to_owned());
        }
        return;
    }
    let Some(below) = levels.checked_sub(1) else {
        return;
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    folders.retain(|path| path.is_dir());
    folders.sort_unstable();
    for folder in folders {
        add_packages(package, &folder, below, found);
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
    notices.pass_over(root, "", &read);
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
