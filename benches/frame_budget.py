#!/usr/bin/env python3
"""Draws docs/images/frame_budget.svg: what a budget of time buys in a frame of a large scene.

    frame_budget.py --punctual BIN [--out FILE.svg] [--bodies 1000] [--frames 60] [--plays 3] [--work DIR]

1,000 torus knots of 4,608 triangles drift and spin, 60 frames a second; nothing is fixed, so every pair of neighbours must be
asked again in every frame. The frames without a budget give the truth. Then the same recording is played within one budget after
another, by the scene and by its simplest rival in turn: a plain loop (`--plain`) sorts the boxes along x, runs one query after
another and remembers nothing. Budgets and times are processor time of the one thread (`--clock cpu`); cpu_ms includes setting the
new poses, which the budget does not. Standard output has the figures as CSV, medians over the plays.
"""

import argparse
import math
import pathlib
import random
import re
import statistics
import subprocess
import tempfile

BUDGETS_MS = [0.125, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0]
DEADLINE_MS = 1.0
COLUMNS = ["budget_ms", "found", "decided", "plain_found", "plain_decided", "wrong", "cpu_ms", "late_median_ms", "late_p99_ms"]


def torus_knot(path, along=192, around=12, p=2, q=3, thickness=0.2):
    """An OBJ file of a closed tube along a (p, q) torus knot, about 1.5 units in radius."""

    def middle(t):
        r = 1.0 + 0.4 * math.cos(q * t)
        return [r * math.cos(p * t), r * math.sin(p * t), 0.4 * math.sin(q * t)]

    def unit(v):
        length = math.sqrt(sum(x * x for x in v))
        return [x / length for x in v]

    def cross(u, v):
        return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]

    with open(path, "w") as out:
        for i in range(along):
            t = 2 * math.pi * i / along
            tangent = unit([b - a for a, b in zip(middle(t - 1e-3), middle(t + 1e-3))])
            side = unit(cross(tangent, [0.0, 0.0, 1.0]))
            up = cross(side, tangent)
            for j in range(around):
                c, s = (thickness * f(2 * math.pi * j / around) for f in (math.cos, math.sin))
                x, y, z = (m + c * u + s * v for m, u, v in zip(middle(t), side, up))
                print(f"v {x:.7g} {y:.7g} {z:.7g}", file=out)
        for i in range(along):
            for j in range(around):
                a, b = i * around + j, i * around + (j + 1) % around
                c, d = (a + around) % (along * around), (b + around) % (along * around)
                print(f"f {a + 1} {c + 1} {b + 1}\nf {b + 1} {c + 1} {d + 1}", file=out)


def record(folder, bodies, frames, seed=1):
    """scene.txt and poses.csv: bodies on a jittered grid, each with a steady velocity and spin of its own."""
    torus_knot(folder / "knot.obj")
    rng = random.Random(seed)
    side = math.ceil(bodies ** (1 / 3))
    spacing = 3.0
    with open(folder / "scene.txt", "w") as out:
        print("mesh 0 knot.obj", file=out)
        for body in range(bodies):
            print(f"body {body} 0 moving", file=out)
    with open(folder / "poses.csv", "w") as out:
        print("frame,body,px,py,pz,qw,qx,qy,qz", file=out)
        starts = []
        for body in range(bodies):
            cell = [body % side, body // side % side, body // side**2]
            place = [spacing * (c + rng.uniform(-0.25, 0.25)) for c in cell]
            velocity = [rng.gauss(0, 0.6) for _ in range(3)]
            axis = [rng.gauss(0, 1) for _ in range(3)]
            length = math.sqrt(sum(x * x for x in axis))
            starts.append((place, velocity, [x / length for x in axis], rng.uniform(0, 6.28), rng.uniform(0.3, 1.5)))
        for frame in range(frames):
            time = frame / 60
            for body, (place, velocity, axis, angle, spin) in enumerate(starts):
                x, y, z = (p + v * time for p, v in zip(place, velocity))
                half = (angle + spin * time) / 2
                w, s = math.cos(half), math.sin(half)
                i, j, k = (s * a for a in axis)
                print(f"{frame},{body},{x:.7g},{y:.7g},{z:.7g},{w:.15g},{i:.15g},{j:.15g},{k:.15g}", file=out)


def play(program, folder, *options):
    """The figures of one play: medians of processor time, the 99 % quantile of its overrun, means of pairs."""
    command = [program, "scene", str(folder), "--clock", "cpu", *options]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    figure = lambda pattern: (re.search(pattern, text) or [None, "nan"])[1]
    rows = [line.split(",") for line in text.splitlines() if line[:1].isdigit()]
    return {
        "cpu_ms": float(figure(r"# cpu median_ms=(\S+)")),
        "late_median_ms": float(figure(r"# overrun median_ms=(\S+)")),
        "late_p99_ms": float(figure(r"# overrun median_ms=\S+ p99_ms=(\S+)")),
        "wrong": float(figure(r" wrong=(\S+)")),
        "pairs": sum(int(row[1]) for row in rows) / len(rows),
        "decided": sum(int(row[2]) for row in rows) / len(rows),
        "hits": sum(int(row[3]) for row in rows) / len(rows),
    }


def compare(program, folder, whole, *options):
    """The figures of a play, with shares of the pairs of a whole frame, for the scene and for the plain loop."""
    scene, plain = play(program, folder, *options), play(program, folder, "--plain", *options)
    share = lambda of, what, all: of[what] / whole[all]
    shares = {"found": share(scene, "hits", "hits"), "decided": share(scene, "decided", "pairs")}
    rival = {"plain_found": share(plain, "hits", "hits"), "plain_decided": share(plain, "decided", "pairs")}
    return {**scene, **shares, **rival}


def draw(rows, whole, bodies):
    """The SVG, for light and dark. Its box is 800 wide and its text 28 high, so that it can be read when shown 400 wide."""
    left, right, top, bottom = 104, 776, 164, 518
    most = max(row["budget_ms"] for row in rows)
    x = lambda ms: left + (right - left) * ms / most
    y = lambda share: bottom - (bottom - top) * share
    text = lambda x, y, words, more="", kind="ink": f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" {more}>{words}</text>'
    line = lambda kind, x1, y1, x2, y2, more="": (
        f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke-width="2.5" {more}/>'
    )

    def curve(kind, column, more):
        points = " ".join(f"{x(row['budget_ms']):.1f},{y(row[column]):.1f}" for row in [{"budget_ms": 0, column: 0}, *rows])
        return f'<polyline class="{kind}" fill="none" stroke-linejoin="round" {more} points="{points}"/>'

    solid, dashed = 'stroke-width="6"', 'stroke-width="4" stroke-dasharray="14 9"'
    at = next(row for row in rows if row["budget_ms"] == DEADLINE_MS)
    # Left of its line where the label would not fit on the right.
    aside = -12 if x(whole) > (left + right) / 2 else 12
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" width="800" height="616" viewBox="0 0 800 616" '
        'font-family="sans-serif" font-size="28">',
        "<style>.back{fill:#fff}.ink{fill:#1f2328}.axis{stroke:#59636e}.grid{stroke:#d1d9e0}.scene{stroke:#0072b2}"
        ".value{fill:#0072b2}.plain{stroke:#b35900}.rival{fill:#b35900}@media(prefers-color-scheme:dark){"
        ".back{fill:#0d1117}.ink{fill:#f0f6fc}.axis{stroke:#9198a1}.grid{stroke:#3d444d}.scene{stroke:#58a6ff}"
        ".value{fill:#58a6ff}.plain{stroke:#f0883e}.rival{fill:#f0883e}}</style>",
        '<rect class="back" width="800" height="616"/>',
        text(20, 44, f"{bodies:,} moving meshes in one frame", 'font-size="32" font-weight="bold"'),
        f'<line class="axis" x1="20" y1="79" x2="76" y2="79" {solid}/>',
        text(88, 88, "touching pairs found"),
        f'<line class="axis" x1="404" y1="79" x2="460" y2="79" {dashed}/>',
        text(472, 88, "pairs decided"),
        text(20, 130, "punctual", 'font-weight="bold"', "value"),
        text(166, 130, "a plain loop over the pairs", 'font-weight="bold"', "rival"),
    ]
    for share in (0, 0.25, 0.5, 0.75, 1):
        parts.append(line("grid", left, y(share), right, y(share)))
        if share != 0.25 and share != 0.75:
            parts.append(text(left - 12, y(share) + 10, f"{100 * share:.0f} %", 'text-anchor="end"'))
    for ms in range(int(most) + 1):
        parts.append(text(x(ms), bottom + 38, ms, 'text-anchor="middle"'))
    parts += [
        text((left + right) / 2, bottom + 80, "budget, milliseconds", 'text-anchor="middle"'),
        line("axis", x(DEADLINE_MS), top, x(DEADLINE_MS), bottom, 'stroke-dasharray="10 8"'),
        line("axis", x(whole), top, x(whole), bottom, 'stroke-dasharray="3 7"'),
        curve("plain", "plain_decided", dashed),
        curve("plain", "plain_found", solid),
        curve("scene", "decided", dashed),
        curve("scene", "found", solid),
        f'<circle class="value" cx="{x(DEADLINE_MS):.1f}" cy="{y(at["found"]):.1f}" r="10"/>',
        text(x(DEADLINE_MS) + 16, y(at["found"]) + 42, f"1 ms: {100 * at['found']:.0f} %", 'font-weight="bold"', "value"),
        text(x(whole) + aside, y(0.06), f"whole frame: {whole:.1f} ms", f'text-anchor="{"end" if aside < 0 else "start"}"'),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--punctual", required=True)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--plays", type=int, default=3)
    parser.add_argument("--work", type=pathlib.Path)
    args = parser.parse_args()
    folder = args.work or pathlib.Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    record(folder, args.bodies, args.frames)

    pairs = folder / "pairs.csv"
    play(args.punctual, folder, "--pairs-out", str(pairs))
    with open(pairs) as lines, open(folder / "truth_pairs.csv", "w") as truth:
        print("frame,a,b", file=truth)
        for line in lines:
            frame, a, b, verdict = line.split(",")[:4]
            if verdict == "intersecting":
                print(f"{frame},{min(int(a), int(b))},{max(int(a), int(b))}", file=truth)
    whole = play(args.punctual, folder, "--reps", "3")
    print(f"# whole frame: {whole['cpu_ms']} ms, {whole['pairs']:.0f} pairs of overlapping boxes, {whole['hits']:.0f} touch")
    print(f"# plain loop: {play(args.punctual, folder, '--plain', '--reps', '3')['cpu_ms']} ms")
    print(",".join(COLUMNS))
    rows = []
    for budget in BUDGETS_MS:
        limit = ["--budget-us", str(1000 * budget)]
        plays = [compare(args.punctual, folder, whole, *limit) for _ in range(args.plays)]
        median = {name: statistics.median(row[name] for row in plays) for name in plays[0]}
        rows.append({"budget_ms": budget, **median})
        print(",".join(f"{rows[-1][name]:g}" for name in COLUMNS), flush=True)
    if args.out:
        args.out.write_text(draw(rows, whole["cpu_ms"], args.bodies))


if __name__ == "__main__":
    main()
