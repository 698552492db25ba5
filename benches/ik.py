#!/usr/bin/env python3
"""Inverse kinematics beside others: random reachable poses of a frame, solved one by one on one core.

    pip install maturin pin pytracik && python/wheel && pip install target/wheels/aghf-*.whl
    taskset -c 0 python3 benches/ik.py
    taskset -c 0 python3 benches/ik.py --robot .../xarm7.urdf --frame link7

Joint positions are drawn uniformly within the limits, or within half a turn of zero where these are wider; Pinocchio
gives the pose of the frame, and the positions are forgotten. Searches begin at the positions within the limits that are
nearest to zero, or at random ones. A pose is solved if the frame is there by Pinocchio, at positions within the limits,
all within 1e-6 m and rad.

- `ours`: `aghf.inverse_kinematics`.
- `trac-ik`: `pytracik`, TRAC-IK of its first solution, with limits of 5 ms and 50 ms and a tolerance of 1e-7 per pose.
- `clik`: Pinocchio's example of closed-loop inverse kinematics, with its step, its damping and its 1000 iterations, a
  tolerance of 1e-7, and up to 20 first guesses, the first within the limits. It knows no limits; its loop is in Python.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio

import aghf
import pytracik

ROOT = Path(__file__).parents[1]
SOLVED, TOLERANCE = 1e-6, 1e-7
# Of Pinocchio's example: the step, the damping and the number of iterations.
STEP, DAMPING, ITERATIONS = 1e-1, 1e-12, 1000
CLIK_GUESSES = 20


class Robot:
    """A robot, as Pinocchio and `aghf` have it."""

    def __init__(self, path: Path, frame: str):
        self.path, self.frame = path, frame
        self.ours = aghf.Model.from_urdf(path)
        self.model = pinocchio.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.id = self.model.getFrameId(frame)
        self.lower, self.upper = np.maximum(self.ours.lower, -np.pi), np.minimum(self.ours.upper, np.pi)
        self.near = np.clip(0.0, self.ours.lower, self.ours.upper)
        self.root = next(frame for frame in self.model.frames if frame.type == pinocchio.FrameType.BODY).name

    def pose(self, q: np.ndarray) -> pinocchio.SE3:
        full = aghf.pinocchio_configuration(self.model, q)
        pinocchio.framesForwardKinematics(self.model, self.data, full)
        return self.data.oMf[self.id].copy()

    def is_solved(self, goal: pinocchio.SE3, q: np.ndarray | None) -> bool:
        if q is None or not np.all((q >= self.ours.lower - SOLVED) & (q <= self.ours.upper + SOLVED)):
            return False
        found = self.pose(q)
        turned = np.linalg.norm(pinocchio.log3(goal.rotation.T @ found.rotation))
        return max(np.linalg.norm(found.translation - goal.translation), turned) < SOLVED


def ours(robot: Robot) -> Callable[[pinocchio.SE3], np.ndarray]:
    return lambda goal: aghf.inverse_kinematics(robot.ours, goal.homogeneous, robot.frame, near=robot.near)


def trac_ik(robot: Robot, seconds: float) -> Callable[[pinocchio.SE3], np.ndarray | None]:
    text = robot.path.read_text(encoding="utf-8")
    chain = pytracik.TRAC_IK(robot.root, robot.frame, text, seconds, TOLERANCE, pytracik.SolveType.Speed)
    count = pytracik.get_num_joints(chain)
    if count != robot.ours.dof:
        raise SystemExit(f"TRAC-IK has {count} joints from {robot.root} to {robot.frame}, not {robot.ours.dof}")

    def solve(goal: pinocchio.SE3) -> np.ndarray | None:
        quaternion = pinocchio.Quaternion(goal.rotation).coeffs()
        answer = np.asarray(pytracik.ik(chain, robot.near, *goal.translation, *quaternion))
        return answer[1:] if answer[0] >= 0 else None

    return solve


def clik(robot: Robot, rng: np.random.Generator) -> Callable[[pinocchio.SE3], np.ndarray | None]:
    model, data = robot.model, robot.data

    def search(goal: pinocchio.SE3, q: np.ndarray) -> np.ndarray | None:
        for _ in range(ITERATIONS):
            pinocchio.framesForwardKinematics(model, data, q)
            difference = data.oMf[robot.id].actInv(goal)
            error = pinocchio.log(difference).vector
            if np.linalg.norm(error) < TOLERANCE:
                return q
            jacobian = pinocchio.computeFrameJacobian(model, data, q, robot.id)
            jacobian = -pinocchio.Jlog6(difference.inverse()) @ jacobian
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + DAMPING * np.eye(6), error)
            q = pinocchio.integrate(model, q, -STEP * step)
        return None

    def solve(goal: pinocchio.SE3) -> np.ndarray | None:
        for number in range(CLIK_GUESSES):
            first = robot.near if number == 0 else rng.uniform(robot.lower, robot.upper)
            q = search(goal, aghf.pinocchio_configuration(model, first))
            if q is not None:
                joints = list(model.joints)[1:]
                angle = [np.arctan2(q[j.idx_q + 1], q[j.idx_q]) if j.nq == 2 else q[j.idx_q] for j in joints]
                turns = np.round((np.clip(angle, robot.lower, robot.upper) - angle) / (2 * np.pi))
                q = angle + 2 * np.pi * turns
                if np.all((q >= robot.ours.lower) & (q <= robot.ours.upper)):
                    return q
        return None

    return solve


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robot", help="the path of a URDF file [default: each of the built-in Kinova and Panda]")
    parser.add_argument("--frame", help="its frame")
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--clik-count", type=int, default=200, help="the number of poses for the loop in Python")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    if bool(given.robot) != bool(given.frame):
        parser.error("--robot and --frame belong together")
    built_in = [("kinova_gen3", "bracelet_link"), ("panda", "panda_link8")]
    robots = [(ROOT / "robots" / name / f"{name}.urdf", frame) for name, frame in built_in]
    if given.robot:
        robots = [(Path(given.robot), given.frame)]
    print("| robot | method | poses | solved | median ms | 99 % ms | mean ms |")
    print("| --- | --- | --: | --: | --: | --: | --: |")
    for path, frame in robots:
        robot, rng = Robot(path, frame), np.random.default_rng(given.seed)
        goals = [robot.pose(q) for q in rng.uniform(robot.lower, robot.upper, (given.count, robot.ours.dof))]
        methods = {"ours": ours(robot), "trac-ik, 5 ms": trac_ik(robot, 5e-3)}
        methods |= {"trac-ik, 50 ms": trac_ik(robot, 50e-3), "clik": clik(robot, rng)}
        for name, solve in methods.items():
            asked = goals[: given.clik_count] if name == "clik" else goals
            times, solved = [], 0
            for goal in asked:
                begin = time.perf_counter()
                q = solve(goal)
                times.append(1e3 * (time.perf_counter() - begin))
                solved += robot.is_solved(goal, q)
            median, last = statistics.median(times), sorted(times)[round(0.99 * (len(times) - 1))]
            row = f"{solved} | {median:.3f} | {last:.2f} | {statistics.fmean(times):.3f}"
            print(f"| {path.stem} | {name} | {len(asked)} | {row} |", flush=True)


if __name__ == "__main__":
    main()
