#!/usr/bin/env python3
"""Makes a case for `compare_peers.py` and `punctual sweep` of any two meshes: poses near their first contact.

    make_case.py --punctual BIN A.obj B.obj DIR [--poses 64] [--seed 1] [--depths=-.002,.001,.005,.02,.05]
                 [--fit] [--turn]

For each pose B is turned at random and comes from afar in a random direction, somewhat off the middle of A, until
`punctual motion` says that the surfaces meet; from there it goes on by one of the depths, drawn at random, in parts
of B's longest extent. Below 0 it stays before the contact. Ways that miss A give no pose. DIR gets a.obj, b.obj,
poses.txt and truth.csv (pose,hit,pairs), as `punctual pair --mode all` tells them.

--fit scales B to A's longest extent; --turn turns B's mesh, so that its boxes do not lie along its axes.
"""

import argparse
import csv
import math
import pathlib
import random
import subprocess


def rotation(rng):
    w, x, y, z = (rng.gauss(0, 1) for _ in range(4))
    s = 2 / (w * w + x * x + y * y + z * z)
    return [
        [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
    ]


def times(matrix, v):
    return [sum(m * x for m, x in zip(row, v)) for row in matrix]


def read(path):
    lines = pathlib.Path(path).read_text().splitlines()
    vertices = [[float(x) for x in line.split()[1:4]] for line in lines if line.startswith("v ")]
    return vertices, [line for line in lines if line.startswith("f ")]


def write(path, vertices, faces):
    lines = ["v {:.6g} {:.6g} {:.6g}".format(*v) for v in vertices] + faces
    path.write_text("\n".join(lines) + "\n")


def middle_and_extent(vertices):
    ends = [(min(axis), max(axis)) for axis in zip(*vertices)]
    return [(low + high) / 2 for low, high in ends], max(high - low for low, high in ends)


def pose(rows, translation):
    return [x for row, t in zip(rows, translation) for x in (*row, t)]


def line(numbers):
    return " ".join(map(repr, numbers)) + "\n"


def rows_of(*command):
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return list(csv.DictReader(row for row in told.splitlines() if not row.startswith("#")))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--punctual", metavar="BIN", required=True, help="the `punctual` program")
    ap.add_argument("a", metavar="A.obj")
    ap.add_argument("b", metavar="B.obj")
    ap.add_argument("out", metavar="DIR", type=pathlib.Path)
    ap.add_argument("--poses", type=int, default=64, metavar="N", help="ways that are tried (default 64)")
    ap.add_argument("--seed", type=int, default=1, metavar="S")
    ap.add_argument("--depths", default="-.002,.001,.005,.02,.05", metavar="D,...", help="in parts of B's extent")
    ap.add_argument("--fit", action="store_true", help="scale B to A's longest extent")
    ap.add_argument("--turn", action="store_true", help="turn B's mesh at random")
    args = ap.parse_args()

    rng = random.Random(args.seed)
    depths = [float(depth) for depth in args.depths.split(",")]
    args.out.mkdir(parents=True, exist_ok=True)
    (of_a, faces_a), (of_b, faces_b) = read(args.a), read(args.b)
    middle_a, extent_a = middle_and_extent(of_a)
    if args.fit:
        scale = extent_a / middle_and_extent(of_b)[1]
        of_b = [[scale * x for x in v] for v in of_b]
    if args.turn:
        turn = rotation(rng)
        of_b = [times(turn, v) for v in of_b]
    middle_b, extent_b = middle_and_extent(of_b)
    a, b, poses, truth = (str(args.out / name) for name in ("a.obj", "b.obj", "poses.txt", "truth.csv"))
    write(args.out / "a.obj", of_a, faces_a)
    write(args.out / "b.obj", of_b, faces_b)

    ways = []
    far = 1.2 * (extent_a + extent_b)
    for _ in range(args.poses):
        rows, way = rotation(rng), [rng.gauss(0, 1) for _ in range(3)]
        way = [-far * x / math.hypot(*way) for x in way]
        target = [m + rng.gauss(0, 0.15 * extent_a) - r for m, r in zip(middle_a, times(rows, middle_b))]
        ways.append((rows, [t - w for t, w in zip(target, way)], way))
    sweeps = args.out / "sweeps.txt"
    sweeps.write_text("".join(line(pose(rows, start) + way) for rows, start, way in ways))
    met = [row["touching_at"] for row in rows_of(args.punctual, "motion", a, b, str(sweeps))]
    sweeps.unlink()
    with open(poses, "w") as file:
        for (rows, start, way), at in zip(ways, met):
            if at:
                share = float(at) + rng.choice(depths) * extent_b / far
                file.write(line(pose(rows, [s + share * w for s, w in zip(start, way)])))
    answers = rows_of(args.punctual, "pair", a, b, poses, "--mode", "all")
    with open(truth, "w") as file:
        file.write("pose,hit,pairs\n")
        file.writelines(f"{row['pose']},{row['hit']},{row['pairs']}\n" for row in answers)
    hits = sum(row["hit"] == "1" for row in answers)
    print(f"{args.out}: {len(answers)} poses, {hits} with contact")


if __name__ == "__main__":
    main()
