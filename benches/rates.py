#!/usr/bin/env python3
"""Solves problems of the Panda with limits of acceleration (15 rad/s^2) and jerk (500 rad/s^3) and 2 cm of clearance.

    cargo build --release
    python3 benches/rates.py --seeds 1-100             # of each family near the limits
    python3 benches/rates.py --problems .../resources/panda/problems --stride 10

Of MotionBenchMaker, which comes with the sources of `vamp-planner`, the free horizon stays; a problem of the families
is given the larger of its own horizon and 1.25 times the least time of its joints within all three limits. The
clearance is from obstacles, and left out where start or goal is nearer. Each motion is solved on one core with all
defaults and judged. Prints one line per motion that is not optimal or not judged valid, and the table. Needs Python
3.9 alone.
"""

import argparse
import json
import statistics
import subprocess
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

from limits import AGHF, percentile, seeds

URDF = Path(__file__).resolve().parents[1] / "robots" / "panda" / "panda.urdf"
ACCELERATION, JERK, CLEARANCE = 15.0, 500.0, 0.02


def least_time(distance: float, v: float, a: float, j: float) -> float:
    """The least time from rest to rest within limits of velocity, acceleration and jerk."""
    to_speed = a / j + v / a if v * j >= a * a else 2.0 * (v / j) ** 0.5
    if distance >= v * to_speed:
        return to_speed + distance / v
    if distance >= 2.0 * a**3 / j**2:
        return a / j + ((a / j) ** 2 + 4.0 * distance / a) ** 0.5
    return (32.0 * distance / j) ** (1.0 / 3.0)


def run(*command) -> subprocess.CompletedProcess:
    return subprocess.run([str(word) for word in command], capture_output=True, text=True)


def generated(aghf: Path, chosen: range):
    """The name and the scenario of each problem near the limits."""
    joints = xml.parse(URDF).findall("joint[@type='revolute']")
    speeds = [float(joint.find("limit").get("velocity")) for joint in joints]
    for family in ("limits", "limits_obstacle"):
        for seed in chosen:
            found = run(aghf, "scenarios", f"{family}_{seed:02}", "--robot", "panda")
            scenario = json.loads(found.stdout)
            # Accelerations that may jump are its own; a jerk within limits asks for the default.
            del scenario["continuity"]
            moved = zip(scenario["q_start"], scenario["q_goal"], speeds)
            least = max(least_time(abs(b - a), v, ACCELERATION, JERK) for a, b, v in moved)
            scenario["horizon_s"] = max(scenario["horizon_s"], 1.25 * least)
            yield family, f"{family}_{seed:02}", scenario


def imported(aghf: Path, problems: Path, stride: int, folder: Path):
    for family in sorted(path for path in problems.iterdir() if path.is_dir()):
        for scene in sorted(family.glob("scene*.yaml"))[::stride]:
            request = scene.with_name(scene.name.replace("scene", "request"))
            file = folder / "imported.json"
            found = run(aghf, "import", "moveit", "--urdf", "panda", scene, request, "-o", file, "--force")
            if found.returncode:
                raise SystemExit(found.stderr)
            yield family.name, f"{family.name} {scene.stem}", json.loads(file.read_text())


def solve(aghf: Path, scenario: dict, folder: Path) -> dict:
    """The summary, with the clearance that was asked for and the word of the judge; or the reason of a refusal."""
    scenario["enforced_limits"].update(acceleration=[ACCELERATION] * 7, jerk=[JERK] * 7)
    file, out = folder / "scenario.json", folder / "out"
    for clearance in (CLEARANCE, 0.0):
        scenario["clearance_m"] = {"obstacles": clearance}
        file.write_text(json.dumps(scenario))
        found = run(aghf, "solve", file, "--json", "--no-report", "--threads", 1, "--out", out, "--force")
        if found.returncode in (0, 3):
            summary = json.loads(found.stdout)
            judged = run(aghf, "judge", file, out / "trajectory.csv").returncode == 0
            return {**summary, "clearance": clearance, "judged": judged}
    return {"refused": found.stderr.strip()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=seeds, default=range(1, 21), help="one seed, or FIRST-LAST")
    parser.add_argument("--problems", type=Path, help="the folder of MotionBenchMaker instead of the families")
    parser.add_argument("--stride", type=int, default=1, help="the step from one of its problems to the next")
    parser.add_argument("--aghf", type=Path, default=AGHF, help="the program")
    options = parser.parse_args()
    families = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.problems:
            problems = imported(options.aghf, options.problems, options.stride, folder)
        else:
            problems = generated(options.aghf, options.seeds)
        for family, problem, scenario in problems:
            found = solve(options.aghf, scenario, folder)
            families.setdefault(family, []).append(found)
            if found.get("verdict") != "optimal" or not found["judged"]:
                outcome = found.get("refused") or (found["verdict"], found["failure"], found["judged"])
                print(problem, outcome, flush=True)
    columns = ["family", "problems", "valid", "optimal", "with 2 cm", "iterations, median"]
    columns += ["median, ms", "99 %, ms", "slowest, ms"]
    print("| " + " | ".join(columns) + " |\n" + "| --- " * len(columns) + "|")
    everything = [found for family in families.values() for found in family]
    for family, all_found in [*families.items(), ("all", everything)]:
        solved = [found for found in all_found if "refused" not in found]
        times = sorted(1e3 * found["solve_seconds"] for found in solved)
        counts = [
            len(all_found),
            sum(found["judged"] for found in solved),
            sum(found["verdict"] == "optimal" for found in solved),
            sum(found["clearance"] > 0.0 for found in solved),
            f"{statistics.median(found['iterations'] for found in solved):.0f}",
            *(f"{percentile(times, share):.0f}" for share in (0.5, 0.99, 1.0)),
        ]
        print(f"| {family} | " + " | ".join(map(str, counts)) + " |")
    return 0 if all(found.get("judged") for found in everything) else 1


if __name__ == "__main__":
    raise SystemExit(main())
