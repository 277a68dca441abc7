#!/usr/bin/env python3
"""Compares `punctual scene` with the scene harnesses of parry and rapier on their scripted scenes, in one run.

    compare_scenes.py --punctual BIN --peers DIR --meshes DIR --work DIR [--frames 240] [--passes 3] [N:MESH...]

N:MESH is a scene of N copies of MESH.obj. The path is written by scene_parry (--frames-out) and read by all, as rotations by
the peers and as quaternions by us. Programs run one after the other, `passes` times over; a frame costs its least CPU time,
new poses and broad phase included; printed are medians over the frames after the first, and the ratios to ours. Hits are
sums over frames of pairs that intersect; peers decide in f32, and rapier by convex pieces of triangles and margins.
"""

import argparse
import os
import subprocess

SCENES = ["200:bunny_1k", "200:motor_4k", "200:spot_6k", "100:armadillo_16k", "200:crank_4k", "64:crank_64k"]


def quaternion(r):
    """(w, x, y, z) of a rotation matrix, by its largest component."""
    (a, b, c), (d, e, f), (g, h, i) = r
    squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    k = max(range(4), key=lambda n: squares[n])
    products = [
        [squares[0], h - f, c - g, d - b],
        [h - f, squares[1], b + d, c + g],
        [c - g, b + d, squares[2], f + h],
        [d - b, c + g, f + h, squares[3]],
    ]
    return [p / (2 * squares[k] ** 0.5) for p in products[k]]


def convert(frames, folder, mesh, bodies):
    os.makedirs(folder, exist_ok=True)
    with open(f"{folder}/scene.txt", "w") as out:
        print(f"mesh 0 {mesh}", file=out)
        for body in range(bodies):
            print(f"body {body} 0 moving", file=out)
    with open(frames) as lines, open(f"{folder}/poses.csv", "w") as out:
        print("frame,body,px,py,pz,qw,qx,qy,qz", file=out)
        for line in lines:
            if line.startswith("#"):
                continue
            frame, body, *m = line.split()
            m = [float(x) for x in m]
            row = [m[3], m[7], m[11]] + quaternion([m[0:3], m[4:7], m[8:11]])
            print(",".join([frame, body] + [repr(x) for x in row]), file=out)


def measure(command, cpu, hits):
    """Median CPU time of the frames after the first, in ms, and the sum of the hits."""
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    header, rows = rows[0], rows[1:]
    times = sorted(int(row[header.index(cpu)]) for row in rows[1:])
    return times[len(times) // 2] / 1e6, sum(int(row[header.index(hits)]) for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ["punctual", "peers", "meshes", "work"]:
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--frames", default="240")
    parser.add_argument("--passes", default="3")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    args = parser.parse_args()
    print("| scene | ours ms | parry any ms | ratio | rapier sensor ms | ratio | hits: ours | parry | rapier |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for scene in args.scenes:
        bodies, mesh = scene.split(":")
        path = os.path.abspath(f"{args.meshes}/{mesh}.obj")
        folder = f"{args.work}/{bodies}_{mesh}"
        os.makedirs(folder, exist_ok=True)
        frames = f"{folder}/frames.txt"
        tail = [bodies, path, args.frames]
        subprocess.run([f"{args.peers}/scene_parry", *tail, "--frames-out", frames], check=True, capture_output=True)
        convert(frames, folder, path, int(bodies))
        passes = ["--passes", args.passes, "--frames-in", frames]
        ours, hits = measure([args.punctual, "scene", folder, "--reps", args.passes], "cpu_ns", "hits")
        parry, parry_hits = measure(
            [f"{args.peers}/scene_parry", *tail, "--kind", "any", *passes], "cpu_ns", "hit_body_pairs"
        )
        rapier, rapier_hits = measure(
            [f"{args.peers}/scene_rapier", *tail, "--kind", "sensor", *passes], "cpu_ns", "hit_body_pairs"
        )
        print(
            f"| {bodies} x {mesh} | {ours:.4f} | {parry:.4f} | {parry / ours:.2f} | {rapier:.4f} | {rapier / ours:.2f} "
            f"| {hits} | {parry_hits} | {rapier_hits} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
