#!/usr/bin/env python3
"""Measures goals by pose: random reachable poses of the last frame, beside the joint goals from which they are made.

    pip install pin numpy
    cargo build --release
    python3 benches/goals.py --robot kinova_gen3 --frame bracelet_link --count 200
    python3 benches/goals.py --robot panda --frame panda_link8 --obstacle
    python3 benches/goals.py --robot .../xarm7.urdf --frame link7
    python3 benches/goals.py --robot kinova_gen3 --frame bracelet_link --upright

Start and goal are drawn uniformly within the position limits, such that the motors hold them; the pose of the goal is
that by Pinocchio, and the joint positions are forgotten. The horizon is one second more than one and a half times the
least one of the joint goal at its velocity limits; all limits are enforced. Both scenarios are solved on one core with
all defaults, and judged; `cpu` is the processor time of the whole program, loading and tests included. With --obstacle
a ball of 0.1 m is halfway between the frame at start and goal, if all joints at both are clear of it by 0.1 m. Draws
with a state in self-collision, which are refused, are drawn again. With --upright goals are joint positions, and the
z axis of the frame stays within five degrees of the vertical, as the hand does with a glass of water: start and goal
are the configurations that `aghf ik` finds from those that are drawn, on twice the horizon.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio

ROOT = Path(__file__).parents[1]
AGHF = ROOT / "target" / "release" / "aghf"
RADIUS, CLEAR = 0.1, 0.1
# The largest number of refused draws, relative to those that are asked for.
MOST_REFUSED = 10
# The exit code of `aghf ik` where no configuration is found.
NOT_FOUND = 3
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

    def pose(self, q: np.ndarray) -> pinocchio.SE3:
        pinocchio.framesForwardKinematics(self.model, self.data, self.full(q))
        return self.data.oMf[self.frame].copy()

    def is_clear(self, q: np.ndarray, centre: np.ndarray) -> bool:
        pinocchio.framesForwardKinematics(self.model, self.data, self.full(q))
        return all(np.linalg.norm(frame.translation - centre) > RADIUS + CLEAR for frame in self.data.oMf)


def scenario(robot: Robot, name: str, with_obstacle: bool) -> tuple[dict, pinocchio.SE3]:
    """A scenario with a joint goal, and the pose of the goal."""
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
        return made, robot.pose(goal)


def upright(robot: Robot, name: str, frame: str) -> dict:
    """A scenario from one upright configuration to another."""
    made, _ = scenario(robot, name, False)
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", default="kinova_gen3", help="a built-in robot or the path of a URDF file")
    parser.add_argument("--frame", default="bracelet_link")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--obstacle", action="store_true")
    parser.add_argument("--upright", action="store_true")
    parser.add_argument("--json", type=Path, help="a file for all numbers")
    parser.add_argument("--starts", type=int, help="the number of starts of goals by pose [default: that of aghf]")
    given = parser.parse_args()
    options = ["--starts", str(given.starts)] if given.starts else []
    builtin = ROOT / "robots" / given.robot / f"{given.robot}.urdf"
    robot = Robot(builtin if builtin.exists() else Path(given.robot), given.frame, given.seed)
    rows, drawn, refused = [], 0, []
    with tempfile.TemporaryDirectory() as folder:
        while given.upright and len(rows) < given.count:
            drawn += 1
            found, why = solve(upright(robot, given.robot, given.frame), Path(folder), [])
            if found is None:
                refused.append(why)
                continue
            times = {"seconds": found["solve_seconds"], "cpu": found["cpu"], "starts": found["starts_tried"]}
            row = {"draw": drawn, "solved": found["success"] and found["judged"], "verdict": found["verdict"]} | times
            if not row["solved"]:
                print(drawn, json.dumps(row), found["failure"], why, flush=True)
            rows.append(row)
        while len(rows) < given.count:
            made, pose = scenario(robot, given.robot, given.obstacle)
            drawn += 1
            joint, why = solve(made, Path(folder), [])
            if joint is None:
                refused.append(why)
                if len(refused) > MOST_REFUSED * given.count:
                    sys.exit(f"{len(refused)} of {drawn} draws are refused, the last one: {why}")
                continue
            row = {"draw": drawn, "joint": joint["success"]}
            rotation = pinocchio.Quaternion(pose.rotation)
            goal = {"frame": given.frame, "position_m": list(pose.translation)}
            goal["orientation_xyzw"] = list(rotation.normalized().coeffs())
            by_pose = {key: value for key, value in made.items() if key not in ("q_goal", "v_goal")}
            found, why = solve(by_pose | {"goal": goal}, Path(folder), options)
            row["solved"] = bool(found and found["success"] and found["judged"])
            if found:
                details = found
                reached = robot.pose(np.array(details["end"]["q"]))
                row["position"] = float(np.linalg.norm(reached.translation - pose.translation))
                row["rotation"] = float(np.linalg.norm(pinocchio.log3(pose.rotation.T @ reached.rotation)))
                row |= {"seconds": found["solve_seconds"], "cpu": found["cpu"], "starts": details["starts_tried"]}
                row["verdict"] = found["verdict"]
                if joint["success"]:
                    row["ratio"] = details["cost"] / joint["cost"]
                    row |= {"joint_seconds": joint["solve_seconds"], "joint_cpu": joint["cpu"]}
            if not row["solved"]:
                print(drawn, json.dumps(row), why, flush=True)
            rows.append(row)
    if given.json:
        given.json.write_text(json.dumps(rows))
    print(f"{len(refused)} draws were refused, as start or goal are in self-collision")
    report(rows)


def report(rows: list[dict]) -> None:
    solved = [row for row in rows if row["solved"]]
    print(f"solved and judged valid: {len(solved)} of {len(rows)}")
    errors = [(row["position"], row["rotation"]) for row in solved if "position" in row]
    if errors:
        position, rotation = np.max(errors, axis=0)
        print(f"largest error: {position:.1e} m, {rotation:.1e} rad")
        print(f"joint goals: {sum(bool(row['joint']) for row in rows)}")
    for key in ("seconds", "joint_seconds", "cpu", "joint_cpu"):
        times = sorted(row[key] for row in solved if key in row)
        if times:
            last = times[min(len(times) - 1, round(0.99 * len(times)))]
            print(f"{key}: median {1e3 * statistics.median(times):.0f} ms, 99 % {1e3 * last:.0f} ms")
    ratios = sorted(row["ratio"] for row in solved if "ratio" in row)
    above = sum(ratio > 1.02 for ratio in ratios)
    if ratios:
        print(
            f"cost beside the joint goal: median {statistics.median(ratios):.3f}, largest {ratios[-1]:.3f}, "
            f"more than 2 % above in {above} of {len(ratios)}"
        )


if __name__ == "__main__":
    main()
