#!/usr/bin/env python3
"""Compares `punctual pair` with the peer harnesses, case by case, in one run on one machine.

    compare_peers.py --punctual BIN --cpp-peers DIR --rust-peers DIR --cases DIR [CASE...]
                     [--reps 7] [--modes any,all] [--out FILE.csv] [--markdown FILE.md]

DIR of --cpp-peers and --rust-peers hold the programs peer_opcode, peer_parry32, ... themselves. DIR of --cases
holds CASE/{a.obj,b.obj,poses.txt,truth.csv}; CASE may be a pattern such as 'tilted_*'.

The measure: every program goes over the whole pose list (sweep order) `reps` times; a pose costs its minimum, pose
update included; a case costs the mean over its poses. Programs run one after the other, never side by side, all of
them on a case before the next case begins, so that a drift of the machine hits all alike; who begins changes from
case to case. Pin the whole run to one core from outside (`taskset -c 1 compare_peers.py ...`).

Mode `any` asks for the first hit, mode `all` for the number of intersecting pairs. Wrong answers are counted against
truth.csv, but a wrong peer still counts as a peer.
"""

import argparse
import csv
import fnmatch
import math
import os
import subprocess
import sys
import time

DEFAULT_CASES = [
    "contact_*",
    "tilted_*",
    "graze_*",
    "path_roll_gear_side_pinion",
    "coincident_gear_side",
    "delta_bunny16k",
    "delta_motor64k",
    "delta_armadillo86k",
    "path_env_rob_sweep",
]

# name, family, program, further arguments. The C++ harnesses do all repetitions in sweep order (their --budget-ms
# acts on repeated poses only); the Rust ones always sweep and stop early unless --max-ms (a pose) is large.
ALL_SWEEPS_CPP = ["--sweep", "--budget-ms", "1e9"]
ALL_SWEEPS_RUST = ["--max-ms", "1e9"]
PEERS = [
    ("opcode:noleaf", "cpp", "peer_opcode", ["--variant", "noleaf"] + ALL_SWEEPS_CPP),
    ("opcode:noleaf-lite", "cpp", "peer_opcode", ["--variant", "noleaf-lite"] + ALL_SWEEPS_CPP),
    ("fcl:obbrss", "cpp", "peer_fcl", ["--variant", "obbrss"] + ALL_SWEEPS_CPP),
    ("coal:kios-bd0", "cpp", "peer_coal", ["--variant", "kios-bd0"] + ALL_SWEEPS_CPP),
    ("embree:refit", "cpp", "peer_embree", ["--variant", "refit"] + ALL_SWEEPS_CPP),
    ("parry leafpairs_opt", "rust", "peer_parry32", ["--method", "leafpairs_opt"] + ALL_SWEEPS_RUST),
    ("obvhs pairwalk", "rust", "peer_obvhs", ["--method", "pairwalk"] + ALL_SWEEPS_RUST),
]
PEER_NAMES = [p[0] for p in PEERS]
OURS = "punctual"
COLUMNS = ["case", "mode", "peer", "poses", "mean_us", "max_us", "max_pose", "wrong_hits", "wrong_pairs", "version", "status"]


def say(text):
    print(text, file=sys.stderr, flush=True)


def parse_arguments():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--punctual", metavar="BIN", help="the `punctual` program")
    ap.add_argument("--cpp-peers", metavar="DIR", help="folder of the C++ peer programs")
    ap.add_argument("--rust-peers", metavar="DIR", help="folder of the Rust peer programs")
    ap.add_argument("--cases", metavar="DIR", required=True, help="folder of the materialized cases")
    ap.add_argument("case", metavar="CASE", nargs="*", help="cases or patterns (default: the list of the comparison)")
    ap.add_argument("--reps", type=int, default=7, metavar="N", help="sweeps over the pose list (default 7)")
    ap.add_argument("--modes", default="any,all", help="default any,all")
    ap.add_argument("--out", metavar="FILE.csv", help="every figure, written as it comes")
    ap.add_argument("--markdown", metavar="FILE.md", help="the tables (default: standard output)")
    ap.add_argument("--peers-only", action="store_true", help="do not run ours")
    ap.add_argument("--reuse-peers", metavar="FILE.csv", help="take peers' rows from an earlier --out where it has them; for development only")
    ap.add_argument("--timeout", type=float, default=300, metavar="S", help="seconds for one program on one case and mode (default 300)")
    a = ap.parse_intermixed_args()
    a.modes = a.modes.split(",")
    if any(m not in ("any", "all") for m in a.modes):
        ap.error("--modes: any, all or both, with a comma between")
    if a.reps < 1:
        ap.error("--reps: at least 1")
    if not os.path.isdir(a.cases):
        ap.error(f"--cases: no folder {a.cases}")
    return a


def pick_cases(folder, patterns):
    present = sorted(d for d in os.listdir(folder) if os.path.exists(os.path.join(folder, d, "poses.txt")))
    picked = []
    for pattern in patterns:
        found = fnmatch.filter(present, pattern)
        if not found:
            say(f"no case {pattern} in {folder}")
        picked += [c for c in found if c not in picked]
    return picked


def read_truth(path):
    """pose -> (hit, pairs)"""
    with open(path, newline="") as f:
        return {int(r["pose"]): (int(r["hit"]), int(r["pairs"])) for r in csv.DictReader(f)}


def measure(command, mode, truth, timeout):
    """Runs one program on one case and mode; the row's figures, or only a status that says why there are none."""
    row = dict.fromkeys(COLUMNS, "")
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        row["status"] = f"timed out after {timeout:g} s"
        return row
    except OSError as e:
        row["status"] = f"cannot run: {e.strerror}"
        return row
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines()
        row["status"] = f"exit {done.returncode}" + (f": {lines[-1]}" if lines else "")
        return row
    figures = {}
    try:
        for line in done.stdout.splitlines():
            if line.startswith("# peer="):
                row["version"] = next((w[8:] for w in line.split() if w.startswith("version=")), "")
            elif line[:1].isdigit():
                pose, hit, pairs, _, ns = line.split(",")[:5]
                figures[int(pose)] = (int(hit), int(pairs), float(ns))
    except ValueError:
        row["status"] = f"cannot read its line: {line}"
        return row
    if not figures or figures.keys() != truth.keys():
        row["status"] = f"{len(figures)} of {len(truth)} poses"
        return row
    slowest = max(figures, key=lambda p: figures[p][2])
    row["poses"] = len(figures)
    row["mean_us"] = sum(f[2] for f in figures.values()) / len(figures) / 1e3
    row["max_us"] = figures[slowest][2] / 1e3
    row["max_pose"] = slowest
    row["wrong_hits"] = sum(figures[p][0] != truth[p][0] for p in truth)
    if mode == "all":
        row["wrong_pairs"] = sum(figures[p][1] != truth[p][1] for p in truth)
    row["status"] = "ok"
    return row


def read_rows(path):
    """Rows of an earlier --out by (case, mode, peer)."""
    rows = {}
    with open(path, newline="") as f:
        for r in csv.DictReader(f):
            if r["status"] == "ok":
                for k in ("mean_us", "max_us"):
                    r[k] = float(r[k])
                for k in ("poses", "max_pose", "wrong_hits"):
                    r[k] = int(r[k])
                if r["wrong_pairs"] != "":
                    r["wrong_pairs"] = int(r["wrong_pairs"])
            rows[r["case"], r["mode"], r["peer"]] = r
    return rows


def run_everything(a, cases, reused):
    """All rows by (case, mode, peer); also written to --out one by one, so that an interrupted run is not lost."""
    programs = []
    if not a.peers_only:
        if a.punctual and os.access(a.punctual, os.X_OK):
            programs.append((OURS, a.punctual, ["pair"], []))
        else:
            say(f"ours missing: no program {a.punctual}" if a.punctual else "ours missing: no --punctual")
    folders = {"cpp": a.cpp_peers, "rust": a.rust_peers}
    for name, family, program, extra in PEERS:
        if folders[family] is not None:
            programs.append((name, os.path.join(folders[family], program), [], extra))
        elif not any(k[2] == name for k in reused):
            say(f"{name} left out: no --{family}-peers")
            continue
        else:
            programs.append((name, None, [], extra))
    rows = {}
    out = open(a.out, "w", newline="") if a.out else None
    try:
        writer = csv.DictWriter(out, COLUMNS) if out else None
        if writer:
            writer.writeheader()
        for number, case in enumerate(cases):
            folder = os.path.join(a.cases, case)
            files = [os.path.join(folder, f) for f in ("a.obj", "b.obj", "poses.txt")]
            truth = read_truth(os.path.join(folder, "truth.csv"))
            start = number % len(programs) if programs else 0
            for mode in a.modes:
                for name, program, first, extra in programs[start:] + programs[:start]:
                    key = case, mode, name
                    began = time.monotonic()
                    if name != OURS and key in reused:
                        row = reused[key]
                    elif program is None:
                        continue
                    else:
                        command = [program] + first + files + ["--mode", mode, "--reps", str(a.reps)] + extra
                        row = measure(command, mode, truth, a.timeout)
                        row.update(case=case, mode=mode, peer=name)
                        figure = f"{row['mean_us']:.3f} us" if row["status"] == "ok" else row["status"]
                        say(f"[{number + 1}/{len(cases)}] {case} {mode} {name}: {figure} ({time.monotonic() - began:.1f} s)")
                    rows[key] = row
                    if writer:
                        shown = {k: f"{v:.4f}" if isinstance(v, float) else v for k, v in row.items()}
                        writer.writerow(shown)
                        out.flush()
    finally:
        if out:
            out.close()
    return rows


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def number(x):
    """Three figures that matter, without exponents."""
    if x is None:
        return "-"
    return f"{x:.0f}" if x >= 99.95 else f"{x:.1f}" if x >= 10 else f"{x:.2f}" if x >= 0.1 else f"{x:.3f}"


def table(header, rows, left=1):
    lines = ["| " + " | ".join(header) + " |"]
    lines.append("|" + "|".join("---" if i < left else "---:" for i in range(len(header))) + "|")
    lines += ["| " + " | ".join(map(str, r)) + " |" for r in rows]
    return lines + [""]


def mode_report(mode, cases, rows):
    def ok(case, peer):
        row = rows.get((case, mode, peer))
        return row if row and row["status"] == "ok" else None

    body, ratios, slowest_own, slowest_all = [], {}, {}, {}
    for case in cases:
        ours = ok(case, OURS)
        peers = [r for r in (ok(case, p) for p in PEER_NAMES) if r]
        best = min(peers, key=lambda r: r["mean_us"], default=None)
        calm = min(peers, key=lambda r: r["max_us"], default=None)
        if ours and best:
            ratios[case] = best["mean_us"] / ours["mean_us"]
            slowest_own[case] = best["max_us"] / ours["max_us"]
            slowest_all[case] = calm["max_us"] / ours["max_us"]
        body.append(
            [
                case,
                number(ours and ours["mean_us"]),
                number(best and best["mean_us"]),
                best["peer"] if best else "-",
                number(ratios.get(case)),
                number(ours and ours["max_us"]),
                number(best and best["max_us"]),
                number(calm and calm["max_us"]),
                calm["peer"] if calm else "-",
            ]
        )
    lines = [f"## Mode `{mode}`", ""]
    lines += table(
        ["case", "ours us", "best peer us", "best peer", "ratio", "slowest pose: ours us", "best peer's us", "least of all peers us", "whose"],
        body,
    )
    if ratios:
        worst = min(ratios, key=ratios.get)
        lines.append(f"Best peer / ours over {len(ratios)} cases: geometric mean **{geometric_mean(ratios.values()):.2f}**, worst **{ratios[worst]:.2f}** ({worst}).")
        for what, slowest in (("the best peer's", slowest_own), ("the least of all peers'", slowest_all)):
            worst = min(slowest, key=slowest.get)
            slower = [c for c in slowest if slowest[c] < 1]
            lines.append(
                f"Slowest pose, {what} / ours: geometric mean {geometric_mean(slowest.values()):.2f}, worst {slowest[worst]:.2f} ({worst}); "
                f"ours slower on {len(slower)}" + (f" ({', '.join(slower)})." if slower else ".")
            )
        lines.append("")

    # every program on its own
    best_on = [r[3] for r in body]
    body = []
    for peer in [OURS] + PEER_NAMES:
        done = [(c, ok(c, peer)) for c in cases if ok(c, peer)]
        if not done:
            continue
        against = [r["mean_us"] / ok(c, OURS)["mean_us"] for c, r in done if ok(c, OURS)]
        body.append(
            [
                peer,
                len(done),
                number(geometric_mean([r["mean_us"] for _, r in done])),
                number(geometric_mean(against)) if against else "-",
                best_on.count(peer) if peer != OURS else "",
                sum(r["wrong_hits"] for _, r in done),
                sum(r["wrong_pairs"] for _, r in done) if mode == "all" else "-",
            ]
        )
    if body:
        lines += table(["program", "cases", "geometric mean us", "/ ours", "best peer on", "poses with wrong hit", "with wrong pair count"], body)

    body = []
    for case in cases:
        twin = "contact_" + case[len("tilted_") :]
        if case.startswith("tilted_") and ok(case, OURS) and ok(twin, OURS):
            tilted, level = ok(case, OURS), ok(twin, OURS)
            body.append([case, number(tilted["mean_us"]), number(level["mean_us"]), f"{tilted['mean_us'] / level['mean_us']:.2f}"])
    if body:
        lines += table(["ours", "tilted us", "untilted us", "tilted / untilted"], body)
    return lines


def report(a, cases, rows, reused, loads):
    lines = [
        f"Mean over poses of the minimum of {a.reps} sweeps, pose update included; one process at a time. "
        f"Load average at begin and end: {loads[0]:.2f}, {loads[1]:.2f}.",
        "",
    ]
    if reused:
        lines += ["**Development figures: peers' rows come from an earlier run.**", ""]
    for mode in a.modes:
        lines += mode_report(mode, cases, rows)
    versions = {r["peer"]: r["version"] for r in rows.values() if r["version"]}
    if versions:
        lines += ["Versions: " + ", ".join(f"{p} {v}" for p, v in sorted(versions.items())) + ".", ""]
    failed = [f"- {c} `{m}` {p}: {r['status']}" for (c, m, p), r in rows.items() if r["status"] != "ok"]
    if failed:
        lines += ["Runs that gave no figure:", ""] + failed + [""]
    return "\n".join(lines)


def main():
    a = parse_arguments()
    cases = pick_cases(a.cases, a.case or DEFAULT_CASES)
    if not cases:
        sys.exit("no cases")
    reused = {k: r for k, r in read_rows(a.reuse_peers).items() if k[2] in PEER_NAMES} if a.reuse_peers else {}
    before = os.getloadavg()[0]
    rows = run_everything(a, cases, reused)
    text = report(a, cases, rows, reused, (before, os.getloadavg()[0]))
    if a.markdown:
        with open(a.markdown, "w") as f:
            f.write(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
