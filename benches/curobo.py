#!/usr/bin/env python3
"""The problems of MotionBenchMaker under the conditions of cuRoboV2, beside its published figures.

    pip install pin numpy
    cargo build --release
    python3 benches/curobo.py                            # the 35 in robots/panda/scenarios
    python3 benches/curobo.py --goal pose                # goals by the pose of the hand, as cuRobo's are
    python3 benches/curobo.py --problems vamp_planner-0.6.4/resources/panda    # all 700

The robot is `panda_inertial.urdf`, within its limits of position and torque, cuRobo's limits of velocity, 15 rad/s^2
and 500 rad/s^3, without and with a payload of 3 kg at the origin of the hand, where cuRobo has it. Each problem is
solved on one core with all defaults and judged by `aghf judge`. Energies, the integral of the sum of |torque velocity|
over the joints, and torques are those of Pinocchio, as in cuRobo's benchmark, at 1 kHz from the positions, velocities
and accelerations of the table; jerks are differences of its accelerations. With --goal pose the joint positions at the
goal serve for the pose only: the search gets no guess of them. Exit code 1 if a motion is not valid.
"""

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio

from limits import percentile

ROOT = Path(__file__).resolve().parents[1]
ROBOT = ROOT / "robots" / "panda" / "panda_inertial.urdf"
HAND = "panda_hand"
# Of cuRobo's URDF; those in ours are the larger ones of the MoveIt configuration.
VELOCITIES = 4 * [2.175] + 3 * [2.61]
ACCELERATION, JERK = 15.0, 500.0
# A search of more seconds is named on the standard error, as is one that ends at no minimum.
SLOW = 5.0
# Whether torques are limited, and the payload in kg.
CASES = [(False, 0.0), (True, 0.0), (False, 3.0), (True, 3.0)]
HEADS = ["solver", "limits of torque", "payload, kg", "valid", "minima", "median, ms", "mean, ms", "98 %, ms"]
HEADS += ["duration, s", "98 %, s", "energy, J", "largest torque, N m", "98 %, N m", "of its limit"]
HEADS.append("largest jerk, rad/s³")
PUBLISHED = [
    ["cuRoboV2, RTX 6000 Ada", "no", "", "99.73 %", "", 35, 38, 81, 1.25, 2.13, 89.3, 71, 133, "", 227],
    ["cuRoboV2, RTX 6000 Ada", "yes", 3, "99.73 %", "", 43, 52, 135, 1.34, "", 81.4, "", 82.5, "", ""],
]


class Arm:
    """The arm with a payload by Pinocchio."""

    def __init__(self, payload: float):
        self.model = pinocchio.buildModelFromUrdf(str(ROBOT))
        frame = self.model.frames[self.model.getFrameId(HAND)]
        point = pinocchio.Inertia(payload, np.zeros(3), np.zeros((3, 3)))
        self.model.appendBodyToJoint(frame.parentJoint, point, frame.placement)
        self.data = self.model.createData()

    def pose(self, q: list) -> dict:
        """The pose of the hand, as a goal."""
        pinocchio.framesForwardKinematics(self.model, self.data, np.array(q))
        place = self.data.oMf[self.model.getFrameId(HAND)]
        turn = pinocchio.Quaternion(place.rotation).coeffs()
        return {"frame": HAND, "position_m": list(place.translation), "orientation_xyzw": list(turn)}

    def measures(self, table: Path) -> dict:
        """The duration of a motion, its energy, and the largest torques and jerks."""
        with open(table, newline="") as file:
            heads, *rows = csv.reader(file)
        rows = np.array(rows, float)
        t = rows[:, 0]
        q, v, a = (rows[:, [i for i, head in enumerate(heads) if head.startswith(f"{kind}_")]] for kind in "qva")
        u = np.array([pinocchio.rnea(self.model, self.data, *sample) for sample in zip(q, v, a)])
        torques = abs(u).max(axis=0)
        return {
            "duration": t[-1],
            "energy": np.trapezoid(abs(u * v).sum(axis=1), t),
            "torque": torques.max(),
            "share": (torques / self.model.effortLimit).max(),
            "jerk": abs(np.diff(a, axis=0) / np.diff(t)[:, None]).max(),
        }


def problems(folder: Path, stride: int, scratch: Path, aghf: Path) -> dict:
    """The scenarios of a folder by their names; those of MotionBenchMaker's scenes and requests are imported."""
    files = sorted(folder.glob("*.json"))[::stride]
    for scene in [] if files else sorted(folder.glob("problems/*/scene*.yaml"))[::stride]:
        request = scene.with_name(scene.name.replace("scene", "request"))
        files.append(scratch / f"{scene.parent.name.removesuffix('_panda')}_{scene.stem.removeprefix('scene')}.json")
        options = ["--urdf", "panda", "--srdf", folder / "panda.srdf", "-o", files[-1]]
        subprocess.run([aghf, "import", "moveit", scene, request, *options], check=True, capture_output=True)
    return {file.stem: json.loads(file.read_text()) for file in files}


def changed(values: dict, arm: Arm, objective: str, torque: bool, payload: float, by_pose: bool) -> dict:
    """A scenario under these conditions."""
    kept = {key: value for key, value in values.items() if key != "free_horizon"}
    limits = {"torque": torque, "max_velocity": VELOCITIES, "acceleration": ACCELERATION, "jerk": JERK}
    kept.update(robot=str(ROBOT), objective=objective, enforced_limits=limits)
    if payload:
        kept["payload"] = {"link": HAND, "mass_kg": payload}
    if by_pose:
        kept["goal"] = arm.pose(kept.pop("q_goal"))
    return kept


def solved(aghf: Path, values: dict, arm: Arm, folder: Path) -> dict:
    """The seconds of the search, the measures of its motion if it is valid, and otherwise the reason."""
    scenario, table, verdict = folder / "scenario.json", folder / "out" / "trajectory.csv", folder / "verdict.json"
    scenario.write_text(json.dumps(values))
    table.unlink(missing_ok=True)
    options = ["--threads", "1", "--rate", "1000", "--no-report", "--json", "--force", "--out", table.parent]
    run = subprocess.run([aghf, "solve", scenario, *options], capture_output=True, text=True)
    if run.returncode not in (0, 3):
        return {"fault": run.stderr.strip()}
    summary = json.loads(run.stdout)
    found = {"seconds": summary["solve_seconds"], "verdict": summary["verdict"]}
    if not table.exists():
        return {**found, "fault": f"{summary['verdict']}: {summary['failure']}"}
    subprocess.run([aghf, "judge", scenario, table, "--json", verdict, "--force"], capture_output=True)
    checks = json.loads(verdict.read_text())["checks"]
    bad = [f"{c['check']} {c.get('value')}" for c in checks if c["outcome"] in ("fail", "undecided", "not_checked")]
    return {**found, **arm.measures(table), **({"fault": f"the judge: {'; '.join(bad)}"} if bad else {})}


def line(objective: str, torque: bool, payload: float, rows: list) -> list:
    """The row of a table: times of all searches, all else of the valid motions."""
    good = [row for row in rows if "fault" not in row]
    times = sorted(1e3 * row["seconds"] for row in rows if "seconds" in row)
    of = lambda key: sorted(row[key] for row in good)
    mean = lambda key: statistics.fmean(of(key))
    result = [f"ours, {objective}", "yes" if torque else "no", f"{payload:.0f}", f"{len(good)}/{len(rows)}"]
    result.append(sum(row["verdict"] == "optimal" for row in good))
    result += [f"{x:.0f}" for x in (percentile(times, 0.5), statistics.fmean(times), percentile(times, 0.98))]
    result += [f"{x:.2f}" for x in (mean("duration"), percentile(of("duration"), 0.98))] + [f"{mean('energy'):.1f}"]
    result += [f"{x:.1f}" for x in (mean("torque"), percentile(of("torque"), 0.98))]
    return [*map(str, result), f"{max(of('share')):.6f}", f"{mean('jerk'):.0f}"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--problems", type=Path, default=ROOT / "robots" / "panda" / "scenarios", help="the folder")
    parser.add_argument("--stride", type=int, default=1, help="take every so many problems")
    parser.add_argument("--objective", nargs="+", default=["least-time", "balanced"], help="presets of the objective")
    parser.add_argument("--goal", choices=["joints", "pose"], default="joints")
    parser.add_argument("--payload", type=float, nargs="+", default=[0.0, 3.0], help="kg")
    parser.add_argument("--limited", action="store_true", help="only within limits of torque")
    parser.add_argument("--aghf", type=Path, default=ROOT / "target" / "release" / "aghf", help="the program")
    options = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        given = problems(options.problems, options.stride, scratch, options.aghf)
        print("| " + " | ".join(HEADS) + " |\n| --- |" + (len(HEADS) - 1) * " --: |", flush=True)
        for objective in options.objective:
            for torque, payload in CASES:
                if payload not in options.payload or options.limited and not torque:
                    continue
                arm, rows = Arm(payload), []
                for name, values in given.items():
                    scenario = changed(values, arm, objective, torque, payload, options.goal == "pose")
                    rows.append(solved(options.aghf, scenario, arm, scratch))
                    conditions = f"{name}, {objective}, torque {torque}, {payload} kg"
                    if rows[-1].get("fault"):
                        failures.append(f"{conditions}: {rows[-1]['fault']}")
                    elif rows[-1]["verdict"] != "optimal" or rows[-1]["seconds"] > SLOW:
                        print(f"{conditions}: {rows[-1]['verdict']}, {rows[-1]['seconds']:.1f} s", file=sys.stderr)
                print("| " + " | ".join(line(objective, torque, payload, rows)) + " |", flush=True)
    for row in PUBLISHED:
        print("| " + " | ".join(map(str, row)) + " |")
    for failure in failures:
        print(f"not valid: {failure}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
