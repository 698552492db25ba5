#!/usr/bin/env python3
"""Solves generated scenarios close to the limits, one after the other, and prints success rates and times.

    cargo build --release
    python3 benches/limits.py                              # Kinova, seeds 1 to 20, without and with obstacle
    python3 benches/limits.py --seeds 1-100 kinova_gen3 ROBOT.urdf ...
    python3 benches/limits.py --family limits -- --degree 12   # arguments after -- are passed to `aghf solve`

Times are the `solve_seconds` of the summaries: the search alone, without the start of the process and the generation.
Mimic joints move independently. Exit code 1 if a scenario is not solved. Needs Python 3.9 and nothing else.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

AGHF = Path(__file__).resolve().parents[1] / "target" / "release" / "aghf"


def seeds(text: str) -> range:
    """`7` or `1-20`."""
    first, _, last = text.partition("-")
    chosen = range(int(first), int(last or first) + 1)
    if not chosen:
        raise argparse.ArgumentTypeError(f"'{text}' has no seed")
    return chosen


def percentile(ascending: list, share: float) -> float:
    """The smallest value not exceeded by at least `share` of all."""
    return ascending[max(math.ceil(share * len(ascending)) - 1, 0)]


def solve(aghf: Path, name: str, robot: str, extra: list, folder: str) -> tuple:
    """The duration of the search in seconds, if there was one, and the reason of a failure, if it failed."""
    of_robot = ["--robot", robot, "--mimic", "independent"]
    command = [aghf, "solve", name, *of_robot, "--json", "--out", folder, "--force", *extra]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode not in (0, 3):
        return None, run.stderr.strip() or f"exit code {run.returncode}"
    summary = json.loads(run.stdout)
    if summary["success"]:
        return summary["solve_seconds"], None
    missed = f"final error {summary['final_error_inf']}, limits broken: {summary['limit_violations']}"
    reason = summary["failure"] or missed
    return summary["solve_seconds"], reason


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robots", nargs="*", default=["kinova_gen3"], help="built-in robots or URDF files")
    parser.add_argument("--seeds", type=seeds, default=range(1, 21), help="one seed, or FIRST-LAST")
    parser.add_argument("--family", nargs="+", default=["limits", "limits_obstacle"], help="families of scenarios")
    parser.add_argument("--aghf", type=Path, default=AGHF, help="the program")
    arguments = sys.argv[1:]
    cut = arguments.index("--") if "--" in arguments else len(arguments)
    extra = arguments[cut + 1 :]
    options = parser.parse_args(arguments[:cut])

    failures = []
    print("| robot | family | solved | median, ms | 90th percentile | 99th | slowest |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for robot in options.robots:
            for family in options.family:
                times, solved = [], 0
                for seed in options.seeds:
                    name = f"{family}_{seed:02}"
                    seconds, failure = solve(options.aghf, name, robot, extra, folder)
                    if seconds is not None:
                        times.append(1e3 * seconds)
                    if failure is None:
                        solved += 1
                    else:
                        failures.append(f"{name} --robot {robot}: {failure}")
                times.sort()
                shares = [percentile(times, s) for s in (0.5, 0.9, 0.99, 1.0)] if times else []
                figures = " | ".join(f"{t:.0f}" for t in shares) or " |  |  | "
                print(f"| {Path(robot).stem} | {family} | {solved}/{len(options.seeds)} | {figures} |", flush=True)
    for failure in failures:
        print(f"not solved: {failure}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
