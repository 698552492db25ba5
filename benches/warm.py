#!/usr/bin/env python3
"""Measures solves from the motion of another solve: of the same problem, and of one with an obstacle moved.

    cargo build --release
    python3 benches/warm.py
    python3 benches/warm.py --scenarios kinova_table_01 robots/panda/scenarios/*.json

Each scenario is solved by each objective with all defaults on one core, then again from its own motion (`--start`)
and, if it has an obstacle, with the first one 8 cm farther along x, from nothing and from that motion. The numbers are
iterations; objectives that a scenario refuses, and those without a minimum, are left out.
"""

import argparse
import copy
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from scenarios import built_in, from_file

ROOT = Path(__file__).parents[1]
AGHF = ROOT / "target" / "release" / "aghf"
OBJECTIVES = ("least-effort", "least-time", "balanced")
# The distance by which an obstacle moves, m.
MOVED = 0.08
BUILT_IN = ("table_01", "obstacles_", "cross_", "gap_", "floor_", "two_arms_0")


def solve(made: dict, folder: Path, out: str, *options: str) -> dict | None:
    """The summary of a solve, if it led to a minimum."""
    file = folder / "scenario.json"
    file.write_text(json.dumps(made))
    asked = [AGHF, "solve", file, "--json", "--no-report", "--threads", "1", "--force", "--out", folder / out, *options]
    run = subprocess.run(asked, capture_output=True, text=True)
    summary = json.loads(run.stdout) if run.stdout else {"verdict": run.stderr}
    return summary if summary["verdict"] == "optimal" else None


def scenario(name: str) -> dict:
    """The scenario of a file, or the one that is built in under a name."""
    if Path(name).exists():
        return from_file(Path(name))
    shown = subprocess.run([AGHF, "scenarios", name], capture_output=True, text=True, check=True)
    return json.loads(shown.stdout)


def rows(name: str, folder: Path):
    """The iterations of a scenario by each objective."""
    for objective in OBJECTIVES:
        made = scenario(name) | {"objective": objective}
        cold = solve(made, folder, "cold")
        if not cold:
            continue
        same = solve(made, folder, "warm", "--start", str(folder / "cold"))
        row = {"name": name, "objective": objective, "cold": cold["iterations"]}
        yield row | {"same": same and same["iterations"]} | moved(made, folder)


def moved(made: dict, folder: Path) -> dict:
    """The iterations with an obstacle moved, from nothing and from the motion before."""
    if not made.get("obstacles"):
        return {}
    made = copy.deepcopy(made)
    pose = made["obstacles"][0].setdefault("pose", {})
    x, y, z = pose.get("position_m", [0.0] * 3)
    pose["position_m"] = [x + MOVED, y, z]
    both = [solve(made, folder, "moved"), solve(made, folder, "moved", "--start", str(folder / "cold"))]
    return dict(zip(("moved_cold", "moved"), (found and found["iterations"] for found in both)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenarios", nargs="+", help="names or files [default: those built in with obstacles]")
    parser.add_argument("--json", type=Path, help="a file for all numbers")
    given = parser.parse_args()
    names = [name for name in built_in(AGHF) if any(part in name for part in BUILT_IN)]
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name in given.scenarios or names:
            for row in rows(name, Path(folder)):
                found.append(row)
                print(json.dumps(row), flush=True)
    if not found:
        sys.exit("no scenario leads to a minimum")
    if given.json:
        given.json.write_text(json.dumps(found))
    same = [row["same"] for row in found if row["same"] is not None]
    print(f"the same problem: {len(same)} of {len(found)}, median {statistics.median(same)}, largest {max(same)}")
    print(f"at most 5 iterations: {sum(count <= 5 for count in same)} of {len(found)}")
    both = [row for row in found if row.get("moved") and row.get("moved_cold")]
    if both:
        share = statistics.median(row["moved"] / row["moved_cold"] for row in both)
        print(f"an obstacle moved: {len(both)}, median share of the iterations from nothing {share:.2f}")


if __name__ == "__main__":
    main()
