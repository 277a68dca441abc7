"""The example that converts MuJoCo models: poses, contacts and distances are those of MuJoCo."""

import importlib.util
from pathlib import Path

import numpy as np
import punctual3d
import pytest

mujoco = pytest.importorskip("mujoco")
EXAMPLE = Path(__file__).resolve().parents[3] / "examples/python/mujoco_to_urdf.py"

MODEL = """
<mujoco>
  <compiler angle="degree" eulerseq="XYZ"/>
  <default>
    <geom size=".1"/>
    <default class="thin"><geom type="capsule" size=".03" rgba="1 0 0 1"/><joint axis="0 1 0" range="-90 90"/></default>
  </default>
  <asset><mesh name="wedge" vertex="0 0 0  .3 0 0  0 .2 0  .1 .1 .4  .1 .1 .2" scale="1 1 2"/></asset>
  <worldbody>
    <geom type="plane" size="0 0 1" pos="0 0 -.4"/>
    <body name="hips" pos="0 0 1" euler="10 20 30">
      <freejoint name="root"/>
      <geom type="ellipsoid" size=".2 .1 .15"/>
      <geom name="shown" size="2" contype="0" conaffinity="0"/>
      <body name="thigh" pos=".1 .05 -.2" quat=".7071 0 .7071 0" childclass="thin">
        <joint name="hip" pos="0 0 .1" ref="20"/>
        <joint name="slider" type="slide" axis="0 0 2" range="-.1 .2"/>
        <geom fromto="0 0 0  .1 0 -.3"/>
        <geom class="main" type="box" size=".02 .05 .1" pos="0 .1 0" contype="2" conaffinity="2"/>
        <frame pos=".1 0 -.3" axisangle="1 1 0 40">
          <body name="shin" xyaxes="0 1 0 -1 0 .2">
            <joint name="knee" class="main" type="ball" pos="0 0 .02"/>
            <geom type="mesh" mesh="wedge" zaxis="1 0 1"/>
            <geom type="cylinder" size=".05 .1" pos="0 0 -.3"/>
          </body>
        </frame>
      </body>
      <body name="tail" pos="-.3 0 0"><joint/><geom type="box" size=".1 .02 .3" contype="3" conaffinity="2"/></body>
      <body name="fin" pos="-.5 0 .1"><joint axis="1 0 0"/><geom type="box" size=".05 .3 .05"/></body>
    </body>
  </worldbody>
  <contact><exclude body1="shin" body2="fin"/></contact>
</mujoco>
"""


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("mujoco_to_urdf", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def turn(example, yaw, pitch, roll):
    axes = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]
    z, y, x = (example.about(np.array(axis), angle) for axis, angle in zip(axes, (yaw, pitch, roll)))
    return z @ y @ x


def test_a_converted_model_says_what_mujoco_says(example, tmp_path):
    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    urdf, srdf = example.convert(model, tmp_path)
    robot = punctual3d.Robot.from_urdf(urdf, srdf=srdf, solids=True)
    # What meets nothing is left out, and bits that differ make links of their own.
    parts = [name for name in robot.link_names if name.startswith("thigh/") and name[-1].isdigit()]
    assert robot.notices == [] and len(parts) == 2
    end = np.zeros(4)
    labels, names = [], robot.joint_names
    for Q in np.random.default_rng(7).uniform(-1, 1, (300, len(names))):
        value = dict(zip(names, Q))
        hips = example.matrix(model.body("hips").quat)
        data.qpos[:3] = model.body("hips").pos + hips @ [value[f"root/{axis}"] for axis in "xyz"]
        for joint, before in ("root", hips), ("knee", np.eye(3)):
            R = before @ turn(example, *(value[f"{joint}/{part}"] for part in ("yaw", "pitch", "roll")))
            mujoco.mju_mat2Quat(end, R.ravel())
            at = model.joint(joint).qposadr[0] + 3 * (joint == "root")
            data.qpos[at : at + 4] = end
        for joint in range(model.njnt):
            name = model.joint(joint).name or f"joint{joint}"
            if name in value:
                data.qpos[model.jnt_qposadr[joint]] = value[name]
        mujoco.mj_forward(model, data)
        poses = robot.link_poses(Q[None])[0]
        for body in ("hips", "thigh", "shin", "tail", "fin"):
            pose, there = poses[robot.link_names.index(body)], data.body(body)
            assert np.abs(pose[:3, 3] - there.xpos).max() < 1e-13
            assert np.abs(pose[:3, :3] - there.xmat.reshape(3, 3)).max() < 1e-13
        deepest = min([data.contact[i].dist for i in range(data.ncon)], default=1.0)
        # The polyhedron of the ellipsoid and the prism of the cylinder reach out of them by less.
        if abs(deepest) > 0.002:
            labels.append(deepest < 0)
            assert robot.collide(Q[None]).verdict[0] == int(labels[-1]), Q
    assert 50 < sum(labels) < len(labels) - 50
    limits = dict(zip(names, robot.joint_limits))
    assert np.allclose(limits["hip"], [-np.pi / 2, np.pi / 2]) and np.allclose(limits["slider"], [-0.1, 0.2])


def test_an_ellipsoid_is_within_its_polyhedron(example):
    text = "<mujoco><worldbody><geom type='ellipsoid' size='1 2 .5'/></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    corners, triangles = example.polyhedron(model, 0)
    tree = punctual3d.Tree(corners, triangles, solid="keep")
    points = np.random.default_rng(1).normal(size=(2000, 3))
    points *= np.array([1.0, 2.0, 0.5]) / np.linalg.norm(points, axis=1, keepdims=True)
    assert tree.open_edges == 0 and tree.contains(points).all()
    assert np.linalg.norm(corners / [1.0, 2.0, 0.5], axis=1).max() < 1.006


def test_what_urdf_does_not_know_is_named(example, tmp_path):
    ground = "<hfield name='h' nrow='2' ncol='2' size='1 1 1 1'/>"
    hill = "<geom name='hill' type='hfield' hfield='h'/>"
    text = f"<mujoco><asset>{ground}</asset><worldbody>{hill}</worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    with pytest.raises(ValueError, match="geom hill: a hfield is not known in URDF"):
        example.convert(model, tmp_path)
