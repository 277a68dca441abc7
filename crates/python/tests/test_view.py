"""Pages of answers: they hold what the answers say."""

import base64
import html
import json
import struct
import subprocess
import sys
import zlib

import numpy as np
import punctual3d
import pytest


def read(page):
    """What a page holds: its description, and the words of 32 bits that this names."""
    data = page.split('id="data">')[1].split("</script>")[0]
    packed = zlib.decompress(base64.b64decode(data))
    length = struct.unpack_from("<I", packed)[0]
    return json.loads(packed[4 : 4 + length]), np.frombuffer(packed[4 + length :], dtype="<u4")


def told(view, step=None):
    """The lines of the table, of the step that is shown first by default."""
    facts = dict(view["steps"][view["start"] if step is None else step]["facts"])
    return {name: text.replace(",", "") for name, text in facts.items()}


def words(view, numbers, place):
    array, start, count = place
    start += view["stage"]["starts"][array]
    return numbers[start : start + count]


def scaled(points):
    return (points - points.mean(axis=0)) / np.ptp(points)


def test_a_stopped_collision_is_shown_as_it_was_answered(ball, ring, touching):
    whole = punctual3d.collide(ball, ring, touching, mode="all")
    part = punctual3d.collide(ball, ring, touching, mode="all", work=4000)
    assert part.stop == "work-limit" and 0 < part.found < whole.found
    view, numbers = read(part.view().html)
    meshes = view["stage"]["meshes"]
    for mesh, tree in zip(meshes, [ball, ring]):
        assert np.array_equal(words(view, numbers, mesh["triangles"]).reshape(-1, 3), tree.faces)
        # Shifted and scaled.
        shown = words(view, numbers, mesh["vertices"]).view("<f4").reshape(-1, 3)
        assert np.allclose(scaled(shown.astype(float)), scaled(tree.vertices), atol=1e-6)
    assert told(view)["Pairs found"] == str(part.found) and told(view, -1)["Pairs found"] == str(whole.found)
    assert view["steps"][view["start"]]["name"].replace(",", "").startswith(f"{part.work} units ")
    _, _, _, place = [surface for surface in view["steps"][-1]["surfaces"] if surface[0] == "met"][0]
    met = {tuple(corners) for corners in words(view, numbers, place).reshape(-1, 3).tolist()}
    assert met == {tuple(corners) for corners in ball.faces[whole.pairs[:, 0]].tolist()}
    assert dict(view["key"])["a"] == "A: mesh of 1,280 triangles"


def test_other_answers_are_shown(ball, ring, touching):
    apart = punctual3d.distance(ball, ring, work=500)
    facts = told(read(apart.view().html)[0])
    assert float(facts["Proven: at least"]) == pytest.approx(apart.low, abs=1e-4)
    closer = punctual3d.closer_than(ball, ring, 0.6).view()
    assert told(read(closer.html)[0])["As close as asked for"] == "yes"
    for options in ({}, {"margin": 0.05}, {"limit": 5}):
        near = punctual3d.contacts(ball, ring, touching, **options)
        assert told(read(near.view().html)[0])["Contacts found"] == str(len(near))
    way = punctual3d.motion(ball, ring, velocity=[2.0, 0.0, 0.0])
    view, _ = read(way.view().html)
    assert told(view)["Proven free until"] == f"{way.free_until:.6f}" and len(view["times"]) == 129
    query = punctual3d.Query(ball, ring, touching, mode="all")
    first, last = query.run(work=3000), query.resume()
    for answer in (first, last):
        assert told(read(answer.view().html)[0])["Pairs found"] == str(answer.found)
    query = punctual3d.DistanceQuery(ball, ring)
    for answer in (query.run(work=6000), query.resume()):
        assert float(told(read(answer.view().html)[0])["Proven: at most"]) == pytest.approx(answer.high, abs=1e-4)


def test_a_scene_is_shown_as_its_last_frame_left_it(ball, tmp_path):
    def at(x):
        return np.array([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=float)

    scene = punctual3d.Scene()
    floor, gone, left, right, alone = (
        scene.insert(ball, at(x), fixed=fixed) for x, fixed in [(-9, True), (50, False), (0, False), (1.9, False), (9, False)]
    )
    scene.remove(gone)
    with pytest.raises(ValueError, match="changed since the last step"):
        scene.view()
    report = scene.step()
    assert report.verdict.tolist() == [1]
    view, _ = read(scene.view(tmp_path / "page.html").html)
    assert (tmp_path / "page.html").read_text() == scene.view().html
    facts, (step,) = told(view), view["steps"]
    assert (facts["Bodies"], facts["Of these, meeting"], facts["Not known"]) == ("4", "1", "0")
    # One mesh for all, each in its colour.
    assert [surface[0] for surface in step["surfaces"]] == ["fixed", "b", "b", "a"] and len(view["stage"]["meshes"]) == 1
    assert "normal" not in dict(view["key"])

    scene.find_contacts()
    scene.step()
    view, numbers = read(scene.view().html)
    points = scene.contact_points(left, right)
    (layer, place), = view["steps"][0]["lines"]
    assert len(points) > 0 and layer == "normal" and "normal" in dict(view["key"])
    assert len(words(view, numbers, place)) == 6 * len(points)

    scene.set_pose(right, at(1.8))
    with pytest.raises(ValueError, match="changed since the last step"):
        scene.view()
    # Without time nothing is known, not even of bodies that are far away.
    report = scene.step(0.0)
    step = read(scene.view().html)[0]["steps"][0]
    assert not report.whole and {surface[0] for surface in step["surfaces"]} == {"fixed", "doubt"}


def test_a_page_is_saved_and_shown_in_a_notebook(ball, ring, tmp_path):
    answer = punctual3d.distance(ball, ring)
    view = answer.view(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == view.html == answer.view().html
    view.save(str(tmp_path / "again.html"))
    assert (tmp_path / "again.html").read_text() == view.html
    frame = view._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and html.unescape(frame.split('"')[1]) == view.html
    assert "kB" in repr(view)
    with pytest.raises(OSError, match="page.html: "):
        answer.view(tmp_path / "no" / "page.html")


def test_answers_keep_their_trees_and_let_them_be_refitted(ball, touching):
    answer = punctual3d.collide(punctual3d.Tree(ball.vertices, ball.faces), punctual3d.shapes.icosphere(2), touching)
    assert told(read(answer.view().html)[0])["Verdict"] == "intersecting"
    moving = punctual3d.Tree(ball.vertices, ball.faces)
    answer = punctual3d.collide(moving, ball, touching)
    before = sys.getrefcount(moving)
    moving.refit(ball.vertices * 1.5)
    with pytest.raises(ValueError, match="a was refitted since it was asked about"):
        answer.view()
    del answer
    assert sys.getrefcount(moving) == before - 1
    assert "html" in punctual3d.collide(ball, moving, touching).view().html


def test_the_same_page_as_the_program(program, ball, ring, touching, tmp_path):
    for name, tree in [("a", ball), ("b", ring)]:
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in tree.vertices.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in tree.faces.tolist()]
        (tmp_path / f"{name}.obj").write_text("\n".join(lines) + "\n")
    np.savetxt(tmp_path / "poses.txt", touching[:3].reshape(1, 12), fmt="%.17g")
    command = [program, "pair", "a.obj", "b.obj", "poses.txt", "--mode", "all", "--budget-work", "4000"]
    subprocess.run([*command, "--view", "page.html"], cwd=tmp_path, check=True, capture_output=True)
    theirs, their_words = read((tmp_path / "page.html").read_text())
    ours, our_words = read(punctual3d.collide(ball, ring, touching, mode="all", work=4000).view().html)
    # But for the names of files.
    assert theirs.pop("key") != ours.pop("key")
    assert theirs == ours and np.array_equal(their_words, our_words)
