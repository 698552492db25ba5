#!/usr/bin/env python3
"""Records what a build finds on problems that a change of structure must not change, and compares two records.

    cargo build --release
    benches/frozen.py record before.json
    benches/frozen.py record after.json --aghf other/target/release/aghf
    benches/frozen.py compare before.json after.json

The problems are all built-in and generated scenarios, those of `robots/panda/scenarios`, and 40 motions of Kinova and
Panda between random states with each objective and with conditions along the way. Each is solved on one core with all
defaults. Compared are the verdicts, the costs, which may differ by a thousandth, the iterations, and the geometric mean
of the ratios of the times.
"""

import argparse
import json
import os
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from scenarios import built_in

ROOT = Path(__file__).resolve().parents[1]
SEED, MIXED = 73, 40
# The centres of the joint ranges from which states are drawn, and half their widths, rad.
STATES = {
    "kinova_gen3": [(0, 2.5), (0, 1.5), (0, 2.5), (0, 2), (0, 2.5), (0, 1.5), (0, 2.5)],
    "panda": [(0, 2), (0, 1.2), (0, 2), (-1.5, 1), (0, 2), (1.8, 1), (0, 2)],
}
FRAMES = {"kinova_gen3": "bracelet_link", "panda": "panda_link8"}
SAME_COST = 1e-3


def mixed() -> dict[str, dict]:
    """Scenarios by their names."""
    draw, found = random.Random(SEED), {}
    for k in range(MIXED):
        robot = list(STATES)[k % 2]
        start, goal = ([centre + draw.uniform(-half, half) for centre, half in STATES[robot]] for _ in range(2))
        scenario = {"robot": robot, "horizon_s": 4.0, "q_start": start, "v_start": [0.0] * 7, "q_goal": goal,
                    "v_goal": [0.0] * 7, "objective": ["least-effort", "balanced", "least-time"][k % 3]}
        if k % 4 >= 2:
            scenario["enforced_limits"] = {"acceleration": 10.0}
        if k % 4 == 3:
            scenario["keep"] = [{"speed": {"frame": FRAMES[robot], "most_m_s": 1.0}}]
        found[f"mixed_{k:02}"] = scenario
    return found


def record(aghf: Path, file: Path) -> None:
    """Solves all problems and writes what was found."""
    names = built_in(aghf)
    paths = [str(path) for path in sorted((ROOT / "robots/panda/scenarios").glob("*.json"))]
    found, environment = {}, {**os.environ, "RAYON_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        for name, scenario in mixed().items():
            path = Path(folder, f"{name}.json")
            path.write_text(json.dumps(scenario), encoding="utf-8")
            paths.append(str(path))
        for problem in names + paths:
            out = Path(folder, "out")
            shutil.rmtree(out, ignore_errors=True)
            run = subprocess.run([aghf, "solve", problem, "--out", out, "--force"], env=environment, text=True,
                                 capture_output=True)
            name = Path(problem).stem
            if run.returncode not in (0, 3):
                found[name] = {"verdict": run.stderr.strip().splitlines()[-1].replace(folder, "")}
                continue
            # One that is not valid has another name.
            (written,) = out.glob("summary*.json")
            summary = json.loads(written.read_text(encoding="utf-8"))
            keys = {"verdict": "verdict", "cost": "cost", "seconds": "solve_seconds", "iterations": "iterations"}
            found[name] = {key: summary.get(of) for key, of in keys.items()}
            print(name, *found[name].values(), flush=True)
    file.write_text(json.dumps(found, indent=1), encoding="utf-8")


def compare(before: Path, after: Path) -> None:
    """Prints the differences of two records, and exits with an error if there are any."""
    a, b = (json.loads(file.read_text(encoding="utf-8")) for file in (before, after))
    differences, ratios = sorted(a.keys() ^ b.keys()), []
    for name in a.keys() & b.keys():
        one, other = a[name], b[name]
        costs = [x.get("cost") for x in (one, other)]
        is_same = None in costs or abs(costs[1] - costs[0]) <= SAME_COST * abs(costs[0])
        if one["verdict"] != other["verdict"] or not is_same:
            differences.append(f"{name}: {one} -> {other}")
        if "seconds" in one and "seconds" in other:
            ratios.append(other["seconds"] / one["seconds"])
    iterations = [sum(x.get("iterations") or 0 for x in record.values()) for record in (a, b)]
    print(*differences, sep="\n")
    mean = statistics.geometric_mean(ratios)
    print(f"{len(ratios)} problems, {len(differences)} differ, iterations {iterations}, times {mean:.3f}")
    sys.exit(bool(differences))


def main() -> None:
    """Runs a command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    own = commands.add_parser("record")
    own.add_argument("file", type=Path)
    own.add_argument("--aghf", type=Path, default=ROOT / "target/release/aghf")
    own = commands.add_parser("compare")
    own.add_argument("before", type=Path)
    own.add_argument("after", type=Path)
    options = parser.parse_args()
    if options.command == "record":
        record(options.aghf.resolve(), options.file)
    else:
        compare(options.before, options.after)


if __name__ == "__main__":
    main()
