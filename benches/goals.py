#!/usr/bin/env python3
"""Measures goals by pose: random reachable poses of the last frame, beside the joint goals from which they are made.

    pip install pin numpy
    cargo build --release
    python3 benches/goals.py --robot kinova_gen3 --frame bracelet_link --count 200
    python3 benches/goals.py --robot panda --frame panda_link8 --obstacle
    python3 benches/goals.py --robot .../xarm7.urdf --frame link7
    python3 benches/goals.py --robot kinova_gen3 --frame bracelet_link --upright
    python3 benches/goals.py --robot panda --frame panda_hand --scenarios robots/panda/scenarios/*.json
    python3 benches/goals.py --robot kinova_gen3 --frame bracelet_link --mixed --count 1000

Start and goal are drawn uniformly within the position limits, such that the motors hold them; the pose of the goal is
that by Pinocchio, and the joint positions are forgotten. The horizon is one second more than one and a half times the
least one of the joint goal at its velocity limits; all limits are enforced. Both scenarios are solved on one core with
all defaults, and judged; `cpu` is the processor time of the whole program, loading and tests included. With --obstacle
a ball of 0.1 m is halfway between the frame at start and goal, if all joints at both are clear of it by 0.1 m. Draws
with a state in self-collision, which are refused, are drawn again. With --upright goals are joint positions, and the
z axis of the frame stays within five degrees of the vertical, as the hand does with a glass of water: start and goal
are the configurations that `aghf ik` finds from those that are drawn, on twice the horizon. With --scenarios
the joint goals are those of files. With --mixed goals are in turn near the start (no joint moves by more than 0.1 rad),
in the middle (0.6 rad) and anywhere, by each of three objectives, with accelerations of at most 10 rad/s^2: the cost is
then that of the objective, the duration with `least-time` and `balanced`.
"""

import argparse
import itertools
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio

from scenarios import from_file

ROOT = Path(__file__).parents[1]
AGHF = ROOT / "target" / "release" / "aghf"
RADIUS, CLEAR = 0.1, 0.1
# The largest number of refused draws, relative to those that are asked for.
MOST_REFUSED = 10
# The number of reasons that are printed.
REASONS = 5
# The exit code of `aghf ik` where no configuration is found.
NOT_FOUND = 3
# The largest way of a joint in mixed goals, rad, the objectives, and the limit of accelerations, rad/s^2 or m/s^2.
WAYS = {"near": 0.1, "middle": 0.6, "far": None}
OBJECTIVES = ("least-time", "balanced", "least-effort")
ACCELERATION = 10.0
# The largest angle of a glass, rad, and that at both ends.
TILT, TILT_AT_ENDS = np.radians(5.0), np.radians(4.5)


class Robot:
    """A robot with its draws."""

    def __init__(self, path: Path, frame: str, seed: int):
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(frame)
        self.rng = np.random.default_rng(seed)

    def full(self, q: np.ndarray) -> np.ndarray:
        """The configuration of Pinocchio: continuous joints have a cosine and a sine."""
        pairs = ((np.cos(x), np.sin(x)) if joint.nq == 2 else (x,) for x, joint in zip(q, self.model.joints[1:]))
        return np.array([x for pair in pairs for x in pair])

    def draw(self) -> np.ndarray:
        while True:
            joints = list(self.model.joints)[1:]
            lower = [self.model.lowerPositionLimit[j.idx_q] if j.nq == 1 else -np.pi for j in joints]
            upper = [self.model.upperPositionLimit[j.idx_q] if j.nq == 1 else np.pi for j in joints]
            q = self.rng.uniform(lower, upper)
            held = pinocchio.computeGeneralizedGravity(self.model, self.data, self.full(q))
            if np.all(np.abs(held) < 0.95 * self.model.effortLimit):
                return q

    def draw_from(self, start: np.ndarray, way: float) -> np.ndarray | None:
        """A goal to which no joint moves farther, or none if it is not within limits and held."""
        goal = start + self.rng.uniform(-way, way, len(start))
        lower, upper = self.model.lowerPositionLimit, self.model.upperPositionLimit
        for joint, x in zip(list(self.model.joints)[1:], goal):
            if joint.nq == 1 and not lower[joint.idx_q] <= x <= upper[joint.idx_q]:
                return None
        held = pinocchio.computeGeneralizedGravity(self.model, self.data, self.full(goal))
        return goal if np.all(np.abs(held) < 0.95 * self.model.effortLimit) else None

    def pose(self, q: np.ndarray) -> pinocchio.SE3:
        pinocchio.framesForwardKinematics(self.model, self.data, self.full(q))
        return self.data.oMf[self.frame].copy()

    def is_clear(self, q: np.ndarray, centre: np.ndarray) -> bool:
        pinocchio.framesForwardKinematics(self.model, self.data, self.full(q))
        return all(np.linalg.norm(frame.translation - centre) > RADIUS + CLEAR for frame in self.data.oMf)


def scenario(robot: Robot, name: str, with_obstacle: bool) -> dict:
    """A scenario with a joint goal."""
    while True:
        start, goal = robot.draw(), robot.draw()
        least = np.max(np.abs(goal - start) / robot.model.velocityLimit)
        zeros = [0.0] * len(start)
        made = {"robot": name, "horizon_s": 1.0 + 1.5 * least, "q_start": list(start), "v_start": zeros}
        made |= {"q_goal": list(goal), "v_goal": zeros}
        if with_obstacle:
            centre = 0.5 * (robot.pose(start).translation + robot.pose(goal).translation)
            if not (robot.is_clear(start, centre) and robot.is_clear(goal, centre)):
                continue
            shape = {"sphere": {"radius_m": RADIUS}}
            made["obstacles"] = [{"shape": shape, "pose": {"position_m": list(centre)}}]
        return made


def mixed(robot: Robot, name: str, number: int) -> dict:
    """A scenario with a joint goal at one of three distances, by one of three objectives."""
    kinds = [(distance, objective) for distance in WAYS for objective in OBJECTIVES]
    distance, objective = kinds[number % len(kinds)]
    while True:
        made = scenario(robot, name, False)
        if WAYS[distance]:
            goal = robot.draw_from(np.array(made["q_start"]), WAYS[distance])
            if goal is None:
                continue
            least = np.max(np.abs(goal - made["q_start"]) / robot.model.velocityLimit)
            made |= {"q_goal": list(goal), "horizon_s": 1.0 + 1.5 * least}
        return made | {"objective": objective, "enforced_limits": {"acceleration": ACCELERATION}}


def upright(robot: Robot, name: str, frame: str) -> dict:
    """A scenario from one upright configuration to another."""
    made = scenario(robot, name, False)
    for key in ("q_start", "q_goal"):
        near = ",".join(str(x) for x in made[key])
        asked = [AGHF, "ik", name, "--frame", frame, "--axis", "0,0,1,0,0,1", "--json"]
        asked += [f"--tolerance-rad={TILT_AT_ENDS}", f"--near={near}"]
        found = subprocess.run(asked, capture_output=True, text=True)
        if found.returncode == NOT_FOUND:
            return upright(robot, name, frame)
        if found.returncode:
            sys.exit(found.stderr.strip())
        made[key] = json.loads(found.stdout)[0]
    axis = {"of_frame": [0, 0, 1], "direction": [0, 0, 1]}
    made["keep"] = [{"poses": {"frame": frame, "axis": axis, "tolerance_rad": TILT}}]
    made["horizon_s"] *= 2.0
    return made


def solve(made: dict, folder: Path, options: list[str]) -> tuple[dict | None, str]:
    """The summary of a solve with the verdict of the judge, or the reason why there is none."""
    file = folder / "scenario.json"
    file.write_text(json.dumps(made))
    out = folder / "out"
    asked = [AGHF, "solve", file, "--json", "--no-report", "--threads", "1", "--out", out, "--force", *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run = subprocess.run(asked, capture_output=True, text=True)
    cpu = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if not run.stdout:
        return None, run.stderr.strip()
    summary = json.loads(run.stdout) | {"cpu": cpu}
    table = out / ("trajectory.csv" if summary["success"] else "trajectory.failed.csv")
    judged = subprocess.run([AGHF, "judge", file, table], capture_output=True, text=True)
    summary["judged"] = judged.returncode == 0
    return summary, judged.stdout if judged.returncode else ""


def by_pose(made: dict, robot: Robot, frame: str) -> tuple[dict, pinocchio.SE3]:
    """The scenario with the pose of the joint goal in its place, and that pose."""
    pose = robot.pose(np.array(made["q_goal"]))
    orientation = pinocchio.Quaternion(pose.rotation).normalized().coeffs()
    goal = {"frame": frame, "position_m": list(pose.translation), "orientation_xyzw": list(orientation)}
    rest = {key: value for key, value in made.items() if key not in ("q_goal", "v_goal")}
    return rest | {"goal": goal}, pose


def measured(found: dict | None, prefix: str = "") -> dict:
    """The figures of a solve under these names."""
    if found is None:
        return {prefix + "solved": False}
    figures = {"seconds": found["solve_seconds"], "cpu": found["cpu"], "starts": found["starts_tried"]}
    figures |= {"verdict": found["verdict"], "solved": found["success"] and found["judged"]}
    objective = found["provenance"]["scenario"].get("objective", "least-effort")
    duration = found["horizon_s"]
    figures |= {"duration": duration, "cost": duration if objective in OBJECTIVES[:2] else found["cost"]}
    return {prefix + key: value for key, value in figures.items()}


def kind_of(made: dict) -> str:
    """The distance of a mixed goal with its objective; empty for others."""
    if "objective" not in made:
        return ""
    way = np.max(np.abs(np.subtract(made["q_goal"], made["q_start"])))
    distance = next((name for name, most in WAYS.items() if most and way <= most), "far")
    return f"{distance}, {made['objective']}"


def row_of(made: dict, robot: Robot, given: argparse.Namespace, folder: Path) -> dict:
    """The figures of a scenario by joints and, but for an upright hand, by pose; those refused have a reason alone."""
    joint, why = solve(made, folder, [])
    if joint is None:
        return {"refused": why}
    if given.upright:
        return measured(joint) | {"why": joint["failure"] or why}
    options = ["--starts", str(given.starts)] if given.starts else []
    asked, pose = by_pose(made, robot, given.frame)
    found, why = solve(asked, folder, options)
    row = {"kind": kind_of(made)} | measured(joint, "joint_") | measured(found)
    row["why"] = (found or {}).get("failure") or why
    if found:
        reached = robot.pose(np.array(found["end"]["q"]))
        row["position"] = float(np.linalg.norm(reached.translation - pose.translation))
        row["rotation"] = float(np.linalg.norm(pinocchio.log3(pose.rotation.T @ reached.rotation)))
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", default="kinova_gen3", help="a built-in robot or the path of a URDF file")
    parser.add_argument("--frame", default="bracelet_link")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--obstacle", action="store_true")
    parser.add_argument("--upright", action="store_true")
    parser.add_argument("--mixed", action="store_true")
    parser.add_argument("--scenarios", type=Path, nargs="+", help="scenarios with joint goals in place of draws")
    parser.add_argument("--json", type=Path, help="a file for all numbers")
    parser.add_argument("--starts", type=int, help="the number of starts of goals by pose [default: that of aghf]")
    given = parser.parse_args()
    if given.upright and given.scenarios:
        parser.error("--upright makes scenarios of its own")
    builtin = ROOT / "robots" / given.robot / f"{given.robot}.urdf"
    robot = Robot(builtin if builtin.exists() else Path(given.robot), given.frame, given.seed)

    numbers = itertools.count()

    def draw() -> dict:
        if given.upright:
            return upright(robot, given.robot, given.frame)
        if given.mixed:
            return mixed(robot, given.robot, next(numbers))
        return scenario(robot, given.robot, given.obstacle)

    draws = iter(draw, None)
    if given.scenarios:
        draws = map(from_file, given.scenarios)
        given.count = len(given.scenarios)
    rows, refused = [], []
    with tempfile.TemporaryDirectory() as folder:
        for number, made in enumerate(draws):
            row = row_of(made, robot, given, Path(folder))
            if "refused" in row:
                refused.append(row["refused"])
                if len(refused) > MOST_REFUSED * given.count:
                    sys.exit(f"{len(refused)} of {number + 1} are refused, the last one: {refused[-1]}")
            else:
                rows.append({"number": number} | row)
                if not row["solved"]:
                    print(json.dumps(rows[-1]), flush=True)
            if len(rows) == given.count:
                break
    if given.json:
        given.json.write_text(json.dumps(rows))
    print(f"{len(refused)} are refused" + "".join(f"\n    {why}" for why in sorted(set(refused))[:REASONS]))
    report(rows)


def report(rows: list[dict]) -> None:
    solved = [row for row in rows if row["solved"]]
    optimal = sum(row["verdict"] == "optimal" for row in solved)
    print(f"solved and judged valid: {len(solved)} of {len(rows)}, {optimal} of them minima")
    errors = [(row["position"], row["rotation"]) for row in solved if "position" in row]
    if errors:
        position, rotation = np.max(errors, axis=0)
        print(f"largest error: {position:.1e} m, {rotation:.1e} rad")
        print(f"joint goals: {sum(row['joint_solved'] for row in rows)}")
    for key in ("seconds", "joint_seconds", "cpu", "joint_cpu"):
        times = sorted(row[key] for row in solved if key in row)
        if times:
            last = times[min(len(times) - 1, round(0.99 * len(times)))]
            print(f"{key}: median {1e3 * statistics.median(times):.0f} ms, 99 % {1e3 * last:.0f} ms")
    both = [row for row in solved if row.get("joint_solved")]
    kinds = sorted({row["kind"] for row in both})
    for kind in dict.fromkeys(["", *kinds]):
        rows = [row for row in both if kind in row["kind"]]
        for key in ("cost", "duration"):
            ratios = sorted(row[key] / row["joint_" + key] for row in rows)
            if ratios:
                above = sum(ratio > 1.02 for ratio in ratios)
                print(
                    f"{kind or 'all'}: {key} beside the joint goal: median {statistics.median(ratios):.3f}, largest "
                    f"{ratios[-1]:.3f}, more than 2 % above in {above} of {len(ratios)}"
                )


if __name__ == "__main__":
    main()
