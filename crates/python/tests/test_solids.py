"""Points and solids: what is inside, how far from the surface, and what is refused."""

import numpy as np
import punctual3d
import pytest

KEEP = r"not built as a solid: build it with solid=\"keep\""


def cube(solid: str, order: int = 1) -> punctual3d.Tree:
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])[:, ::order]
    return punctual3d.Tree(corners, faces, solid=solid)


POINTS = np.array([[0.5, 0.5, 0.75], [0.5, 0.5, 2.0], [1.0, 0.5, 0.5], [-0.25, 0.5, 0.5]])


@pytest.mark.parametrize("solid", ["keep", "flip"])
def test_points_of_a_cube(solid: str) -> None:
    tree = cube(solid)
    assert (tree.open_edges, tree.volume) == (0, 1.0)
    assert tree.contains(POINTS).tolist() == [True, False, True, False]
    np.testing.assert_allclose(tree.signed_distance(POINTS), [-0.25, 1.0, 0.0, 0.25], atol=1e-13)
    assert tree.contains(POINTS[0]).tolist() == [True]
    assert len(tree.contains(np.empty((0, 3)))) == 0
    assert punctual3d.Tree.from_bytes(tree.to_bytes()).contains(POINTS[:1]).tolist() == [True]


def test_mass_properties_of_a_cube() -> None:
    volume, center, inertia = cube("keep").mass_properties()
    assert abs(volume - 1) < 1e-15
    np.testing.assert_allclose(center, [0.5, 0.5, 0.5], atol=1e-15)
    np.testing.assert_allclose(inertia, np.eye(3) / 6, atol=1e-15)
    with pytest.raises(ValueError, match=KEEP):
        cube("no").mass_properties()
    with pytest.raises(ValueError, match="the solid has 3 open edges, one from vertex"):
        whole = cube("keep")
        punctual3d.Tree(whole.vertices, whole.faces[1:], solid="keep").mass_properties()


def test_what_is_inside_out_is_kept_or_flipped() -> None:
    kept, flipped = cube("keep", -1), cube("flip", -1)
    with pytest.raises(ValueError, match="inside out"):
        kept.mass_properties()
    assert kept.volume == -1.0 and not kept.contains(POINTS).tolist()[0]
    assert flipped.volume == 1.0 and flipped.contains(POINTS).tolist()[0]


@pytest.mark.parametrize("mode", ["nearest", "any", "all"])
def test_rays_say_whether_they_start_inside(mode: str) -> None:
    hits = punctual3d.rays(cube("keep"), POINTS, [1, 0, 0], mode=mode, solid=True)
    assert hits.starts_inside is not None and hits.starts_inside.tolist() == [True, False, True, False]
    cut = punctual3d.rays(cube("keep"), POINTS, [1, 0, 0], mode=mode, solid=True, work=0)
    assert cut.stop == "work-limit" and cut.starts_inside is not None and not cut.starts_inside.any()
    assert punctual3d.rays(cube("keep"), POINTS, [1, 0, 0], mode=mode).starts_inside is None
    with pytest.raises(ValueError, match=KEEP):
        punctual3d.rays(cube("no"), POINTS, [1, 0, 0], solid=True)


def test_refusals_name_the_place() -> None:
    surface = cube("no")
    assert surface.open_edges is None and surface.volume is None
    with pytest.raises(ValueError, match=KEEP):
        surface.contains(POINTS)
    with pytest.raises(ValueError, match=KEEP):
        surface.signed_distance(POINTS)
    with pytest.raises(ValueError, match=KEEP):
        punctual3d.penetration(surface, surface, solid=True)
    assert punctual3d.penetration(surface, cube("flip"), solid=True).high > 0
    with pytest.raises(ValueError, match="point 1 is not finite along axis 2"):
        cube("keep").signed_distance([[0, 0, 0], [0, 0, np.nan]])
    with pytest.raises(ValueError, match="solid"):
        cube("yes")
    with pytest.raises(ValueError, match="points: shape"):
        cube("keep").contains(np.zeros((2, 2)))


def test_a_cube_in_a_cube_collides() -> None:
    outer = cube("keep")
    corners = np.asarray(outer.vertices) * 0.5 + 0.25
    inner = punctual3d.Tree(corners, outer.faces, solid="keep")
    found = punctual3d.collide(outer, inner)
    assert found.verdict == "contained"
    assert punctual3d.distance(outer, inner).high == 0.0


def test_a_question_without_room_tells_nothing_of_the_one_before() -> None:
    """A thread keeps its workspace from call to call."""
    outer = cube("keep")
    inner = punctual3d.Tree(np.asarray(outer.vertices) * 0.5 + 0.25, outer.faces, solid="keep")
    away = np.eye(4)
    away[0, 3] = 9.0
    before = [
        lambda: punctual3d.collide(outer, inner),
        lambda: punctual3d.collide(outer, inner, work=300),
        lambda: punctual3d.distance(outer, inner),
        lambda: punctual3d.manifolds(outer, outer, skin=0.1),
        lambda: punctual3d.rays(outer, POINTS, [1, 0, 0], solid=True),
        lambda: outer.signed_distance(POINTS),
        lambda: outer.contains(POINTS[2:3]),
    ]
    for earlier in before:
        for work in (0, 1):
            earlier()
            assert punctual3d.collide(inner, outer, away, work=work).verdict in ("undecided", "separated")
            earlier()
            found = punctual3d.distance(inner, outer, away, work=work)
            assert found.low <= 8.25 <= found.high
            earlier()
            hits = punctual3d.rays(inner, [[30.0, 0.5, 0.5]], [1, 0, 0], solid=True, work=work)
            assert len(hits) == 1 and hits.starts_inside is not None and not hits.starts_inside[0]
            earlier()
            found = punctual3d.manifolds(inner, outer, away, skin=0.1, work=work)
            assert len(found) == 0
