"""A MuJoCo model as URDF, SRDF and meshes: mujoco_to_urdf.py MODEL.xml FOLDER

MuJoCo itself reads the model, so that all of its format counts. Joints turn and slide with qpos; a free joint counts
from where its body stands in the file, as x, y, z, yaw, pitch, roll; a ball joint is yaw, pitch, roll. Joints that an
equality ties to another one follow it. Meshes are their convex hulls, as in MuJoCo. An ellipsoid is a polyhedron around
it, nowhere farther from it than 0.6 % of its longest half axis. A plane is a box of 2 km, 10 m deep. The SRDF file
disables the pairs that MuJoCo does not check. A body whose geometries differ in what they meet becomes several links.
Geometries that meet nothing are left out.
"""

import sys
from itertools import combinations
from math import atan2, cos, hypot, sin
from pathlib import Path
from xml.sax.saxutils import quoteattr

import mujoco
import numpy as np

KINDS = {int(kind): name[7:].lower() for name, kind in mujoco.mjtGeom.__members__.items()}
JOINTS = {int(kind): name[6:].lower() for name, kind in mujoco.mjtJoint.__members__.items()}


def matrix(quaternion):
    """The rotation of a quaternion w, x, y, z."""
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, quaternion / np.linalg.norm(quaternion))
    return R.reshape(3, 3)


def about(axis, angle):
    quaternion = np.zeros(4)
    mujoco.mju_axisAngle2Quat(quaternion, axis, angle)
    return matrix(quaternion)


def origin(R, position):
    """R = Rz(yaw) Ry(pitch) Rx(roll), to the last bits wherever the pitch is."""
    roll = atan2(R[2, 1], R[2, 2])
    c, s = cos(roll), sin(roll)
    yaw = atan2(s * R[0, 2] - c * R[0, 1], c * R[1, 1] - s * R[1, 2])
    rpy = roll, atan2(-R[2, 0], hypot(R[2, 1], R[2, 2])), yaw
    return f"<origin rpy='{words(rpy)}' xyz='{words(position)}'/>"


def words(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def polyhedron(model, geom):
    """Vertices and triangles of the hull of a mesh, or of a polyhedron around an ellipsoid."""
    if KINDS[model.geom_type[geom]] == "mesh":
        mesh = model.geom_dataid[geom]
        begin, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        graph = model.mesh_graph[model.mesh_graphadr[mesh] :]
        if model.mesh_graphadr[mesh] < 0:
            raise ValueError(f"mesh {model.mesh(mesh).name}: MuJoCo made no hull of it")
        vertices, faces = graph[:2]
        first = 2 + 3 * vertices + 3 * faces
        return model.mesh_vert[begin : begin + count], graph[first : first + 3 * faces].reshape(-1, 3)
    rows, columns = 32, 64
    angles = np.arange(1, rows) * np.pi / rows, np.arange(columns) * 2 * np.pi / columns
    polar, turn = np.meshgrid(*angles, indexing="ij")
    ring = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], -1)
    ball = np.concatenate([ring.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    # The last row above the first, and the first below the last, are the poles.
    at = np.arange(len(ball) - 2).reshape(-1, columns)
    at = np.vstack([np.full(columns, len(ball) - 2), at, np.full(columns, len(ball) - 1)])
    a, b, c, d = at[:-1], np.roll(at[:-1], -1, 1), at[1:], np.roll(at[1:], -1, 1)
    halves = np.stack([a, c, d], -1)[:-1], np.stack([a, d, b], -1)[1:]
    triangles = np.concatenate([half.reshape(-1, 3) for half in halves])
    # No face of the ball within it is nearer to the middle than the product of both cosines.
    return ball * model.geom_size[geom] / (cos(np.pi / 2 / rows) * cos(np.pi / columns)), triangles


def shape(model, geom, folder):
    """The element of a geometry, and its place in the body."""
    R, position = matrix(model.geom_quat[geom]), model.geom_pos[geom]
    kind, size = KINDS[model.geom_type[geom]], model.geom_size[geom]
    if kind in ("mesh", "ellipsoid"):
        file = folder / f"{kind}_{model.geom_dataid[geom] if kind == 'mesh' else geom}.obj"
        vertices, triangles = polyhedron(model, geom)
        lines = [f"v {words(vertex)}" for vertex in vertices]
        file.write_text("\n".join(lines + ["f {} {} {}".format(*triangle) for triangle in triangles + 1]))
        element = f"<mesh filename={quoteattr(file.name)}/>"
    elif kind == "plane":
        position = position - 5 * R[:, 2]
        element = "<box size='2000 2000 10'/>"
    elif kind == "box":
        element = f"<box size='{words(2 * size)}'/>"
    elif kind in ("sphere", "capsule", "cylinder"):
        length = "" if kind == "sphere" else f" length='{words(2 * size[1:2])}'"
        element = f"<{kind} radius='{words(size[:1])}'{length}/>"
    else:
        raise ValueError(f"geom {model.geom(geom).name or geom}: a {kind} is not known in URDF")
    return f"<collision>{origin(R, position)}<geometry>{element}</geometry></collision>"


def convert(model, folder):
    """Writes robot.urdf, robot.srdf and meshes to a folder; the paths of both."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    body_name = [model.body(i).name or f"body{i}" for i in range(model.nbody)]
    joint_name = [model.joint(i).name or f"joint{i}" for i in range(model.njnt)]
    text, parts, part_of = [], {}, {}
    for geom in range(model.ngeom):
        body, *bits = key = (model.geom_bodyid[geom], model.geom_contype[geom], model.geom_conaffinity[geom])
        if any(bits):
            parts.setdefault(key, []).append(shape(model, geom, folder))
            part_of[geom] = key
    mimics = {}
    for i in range(model.neq):
        is_joint = model.eq_type[i] == int(mujoco.mjtEq.mjEQ_JOINT) and model.eq_obj2id[i] >= 0
        if is_joint and not model.eq_data[i, 2:5].any():
            (a, b), (offset, factor) = (model.eq_obj1id[i], model.eq_obj2id[i]), model.eq_data[i, :2]
            at = model.qpos0[model.jnt_qposadr[[a, b]]]
            values = f"multiplier='{words([factor])}' offset='{words([at[0] + offset - factor * at[1]])}'"
            mimics[a] = f"<mimic joint={quoteattr(joint_name[b])} {values}/>"

    def link(name, shapes=()):
        text.append(f"<link name={quoteattr(name)}>{''.join(shapes)}</link>")
        return name

    def joint(kind, name, parent, child, place, rest=""):
        links = f"<parent link={quoteattr(parent)}/><child link={quoteattr(child)}/>"
        text.append(f"<joint type='{kind}' name={quoteattr(name)}>{links}{origin(*place)}{rest}</joint>")
        return child

    link(body_name[0])
    for body in range(1, model.nbody):
        place = matrix(model.body_quat[body]), model.body_pos[body]
        parent, anchor = body_name[model.body_parentid[body]], np.zeros(3)
        for j in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            kind, axis, name = JOINTS[model.jnt_type[j]], model.jnt_axis[j], joint_name[j]
            place = place[0], place[1] + place[0] @ (model.jnt_pos[j] - anchor)
            anchor, start = model.jnt_pos[j], model.qpos0[model.jnt_qposadr[j]]
            lower, upper = model.jnt_range[j]
            rest = f"<axis xyz='{words(axis)}'/>" + mimics.get(j, "")
            if model.jnt_limited[j]:
                rest += f"<limit lower='{words([lower])}' upper='{words([upper])}'/>"
            if kind == "free":
                steps = [("floating", "", "")]
            elif kind == "ball":
                axes = ("/yaw", "0 0 1"), ("/pitch", "0 1 0"), ("/roll", "1 0 0")
                steps = [("continuous", end, f"<axis xyz='{axis}'/>") for end, axis in axes]
            elif kind == "slide":
                place = place[0], place[1] - place[0] @ axis * start
                steps = [("prismatic", "", rest)]
            else:
                place = place[0] @ about(axis, -start), place[1]
                steps = [("revolute" if model.jnt_limited[j] else "continuous", "", rest)]
            for kind, end, rest in steps:
                moved = link(f"{name}{end}/moved")
                parent = joint(kind, name + end, parent, moved, place, rest)
                place = np.eye(3), np.zeros(3)
        place = place[0], place[1] - place[0] @ anchor
        joint("fixed", f"{body_name[body]}/fixed", parent, link(body_name[body]), place)
    names = {key: f"{body_name[key[0]]}/{number}" for number, key in enumerate(parts)}
    for key, shapes in parts.items():
        joint("fixed", names[key], body_name[key[0]], link(names[key], shapes), (np.eye(3), np.zeros(3)))

    told = {(part_of.get(a), part_of.get(b)) for a, b in zip(model.pair_geom1, model.pair_geom2)}
    excluded = set(model.exclude_signature.tolist())
    keeps_parents = model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    weld, off = model.body_weldid, []
    for a, b in combinations(parts, 2):
        low, high = sorted((int(a[0]), int(b[0])))
        roots = weld[a[0]], weld[b[0]]
        above = [weld[model.body_parentid[root]] for root in roots]
        is_next = 0 not in roots and (roots[0] == above[1] or roots[1] == above[0]) and not keeps_parents
        is_off = is_next or (low << 16) + high in excluded or not (a[1] & b[2] or b[1] & a[2])
        if is_off and (a, b) not in told and (b, a) not in told:
            off.append(f"<disable_collisions link1={quoteattr(names[a])} link2={quoteattr(names[b])} reason='MuJoCo'/>")
    for name, lines in ("robot.urdf", text), ("robot.srdf", off):
        (folder / name).write_text("<robot name='robot'>\n" + "\n".join(lines) + "\n</robot>\n")
    return folder / "robot.urdf", folder / "robot.srdf"


if __name__ == "__main__":
    print(*convert(mujoco.MjModel.from_xml_path(sys.argv[1]), sys.argv[2]), sep="\n")
