#!/usr/bin/env python3
"""Build and refit times of trees, against peers, all in one run: a table in Markdown.

The peers print the time to build the trees of both meshes of a case (`# peer=... build_ns=...`), as `punctual pair` does;
each program is started --reps times, one after the other in turn, and the least time counts. Presets, threads and
refits are those of `punctual info`, of mesh A alone, in milliseconds and nanoseconds a triangle.

    benches/compare_builds.py --punctual BIN --cpp-peers DIR --rust-peers DIR --cases DIR [CASE...]
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile

DEFAULT_CASES = ["delta_motor64k", "delta_bunny69k", "delta_armadillo86k", "delta_crank64k", "delta_propeller64k"]

# name, family, program, its options
PEERS = [
    ("embree:refit", "cpp", "peer_embree", ["--reps", "1", "--variant", "refit"]),
    ("embree:rebuild-med", "cpp", "peer_embree", ["--reps", "1", "--variant", "rebuild-med"]),
    ("parry leafpairs_opt", "rust", "peer_parry32", ["--reps", "1", "--method", "leafpairs_opt"]),
    ("obvhs pairwalk", "rust", "peer_obvhs", ["--reps", "1", "--method", "pairwalk"]),
]
OURS = "punctual"
PRESETS = [("fast", 1), ("normal", 1), ("normal", 2), ("best", 1)]


def parse_arguments():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--punctual", metavar="BIN", required=True, help="the `punctual` program")
    ap.add_argument("--cpp-peers", metavar="DIR", help="folder of the C++ peer programs")
    ap.add_argument("--rust-peers", metavar="DIR", help="folder of the Rust peer programs")
    ap.add_argument("--cases", metavar="DIR", required=True, help="folder of the materialized cases")
    ap.add_argument("case", metavar="CASE", nargs="*", default=DEFAULT_CASES)
    ap.add_argument("--reps", type=int, default=15, metavar="N", help="starts of each program (default 15)")
    return ap.parse_intermixed_args()


def run(command):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: exit {done.returncode}: {done.stderr.strip()[-200:]}")
    return done.stdout


def build_ns(command):
    found = re.search(r"build_ns=([0-9.]+)", run(command))
    if not found:
        sys.exit(f"{command[0]} says no build time")
    return float(found[1])


def case_times(a, folder, poses):
    """Least build time of both meshes by program, ns."""
    with open(os.path.join(folder, "poses.txt")) as f:
        first = next(line for line in f if line.strip() and not line.startswith("#"))
    with open(poses, "w") as f:
        f.write(first)
    meshes = [os.path.join(folder, m) for m in ("a.obj", "b.obj")]
    commands = {OURS: [a.punctual, "pair", *meshes, poses, "--mode", "any"]}
    folders = {"cpp": a.cpp_peers, "rust": a.rust_peers}
    for name, family, program, options in PEERS:
        if folders[family]:
            commands[name] = [os.path.join(folders[family], program), *meshes, poses, "--mode", "any", *options]
    least = dict.fromkeys(commands, float("inf"))
    for _ in range(a.reps):
        for name, command in commands.items():
            least[name] = min(least[name], build_ns(command))
    return least


def preset_times(a, mesh):
    """(triangles, build ms, refit ms) of each preset."""
    rows = []
    for effort, threads in PRESETS:
        text = run([a.punctual, "info", "--effort", effort, "--threads", str(threads), "--reps", str(4 * a.reps), mesh])
        field = lambda name: float(re.search(rf"^ *{name} +([0-9.]+)$", text, re.M)[1])
        rows.append((field("triangles"), field("build ms"), field("refit ms")))
    return rows


def table(header, rows):
    print("| " + " | ".join(header) + " |")
    print("|---|" + "---:|" * (len(header) - 1))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)
    print()


def main():
    a = parse_arguments()
    before = os.getloadavg()[0]
    peers, presets = [], []
    with tempfile.TemporaryDirectory() as temporary:
        for case in a.case:
            folder = os.path.join(a.cases, case)
            least = case_times(a, folder, os.path.join(temporary, "poses.txt"))
            ours = least[OURS]
            peers.append([case] + [f"{ns / 1e6:.1f}" + ("" if name == OURS else f" ({ns / ours:.2f})") for name, ns in least.items()])
            rows = preset_times(a, os.path.join(folder, "a.obj"))
            triangles, refit = rows[0][0], rows[1][2]
            presets.append([case, f"{triangles:.0f}"] + [f"{build:.1f}" for _, build, _ in rows] + [f"{refit:.2f} ({1e6 * refit / triangles:.0f})"])
            names = list(least)
            print(f"{case} done", file=sys.stderr)
    print("Build of both trees, ms, one thread (peer / ours):\n")
    table(["case"] + names, peers)
    print("Mesh A, ms:\n")
    table(["case", "triangles"] + [f"{effort}, {threads} thread{'s'[:threads > 1]}" for effort, threads in PRESETS] + ["refit (ns a triangle)"], presets)
    print(f"Least of {a.reps} runs in turn, and of {4 * a.reps} in a row. Load average at begin and end: {before:.2f}, {os.getloadavg()[0]:.2f}.")


if __name__ == "__main__":
    main()
