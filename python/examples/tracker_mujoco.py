"""A closed loop with MuJoCo: a robot that weighs 20 % more than its model, with damping and friction, follows a target
that moves at up to 0.3 m/s, among a table, a post and a ball that crosses; aghf replans at 500 Hz, and sees target and
ball at 50 Hz.

The target is one of the joints: two of them swing, so slowly that the tool keeps the speed. Plans have the least
acceleration: one that ends at rest moves like the target now if its goal is where that will be after two thirds of the
horizon. The simulation waits for each step.

    pip install matplotlib mujoco
    python python/examples/tracker_mujoco.py [--seconds 60] [--robot panda] [--page loops.html]
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco_replay import order_of, specification_of
from tracker_page import Loop, write

import aghf

PERIOD, SUBSTEPS, HORIZON, SPEED = 0.002, 4, 0.5, 0.3
HEAVIER, CLEARANCE, BESIDE = 1.2, 0.02, 0.15
# Friction of 1 % of the largest torque, and as much from damping at the largest velocity.
LOSSES = 0.01
START = {
    "kinova_gen3": [0.0, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0],
    "panda": [0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.785],
}
SIZES = {"box": (0.5, 0.8, 0.04), "cylinder": (0.05, 0.6), "sphere": (0.08,)}
PLACES = {"box": [0.6, 0.0, 0.0], "cylinder": [-0.45, 0.3, 0.3], "sphere": [0.9, 0.0, 0.9]}
TYPES = {name: getattr(mujoco.mjtGeom, f"mjGEOM_{name.upper()}") for name in SIZES}


def obstacles(ball: np.ndarray) -> list[dict[str, Any]]:
    """The obstacles as a scenario writes them."""
    box, (radius, length), (of_ball,) = SIZES.values()
    shapes: list[dict[str, Any]] = [
        {"box": {"size_m": box}},
        {"cylinder": {"radius_m": radius, "length_m": length}},
        {"sphere": {"radius_m": of_ball}},
    ]
    places = [PLACES["box"], PLACES["cylinder"], ball.tolist()]
    return [{"shape": shape, "pose": {"position_m": p}} for shape, p in zip(shapes, places, strict=True)]


def tool(model: aghf.Model, q: np.ndarray) -> np.ndarray:
    return aghf.frame_placement(model, q, model.frame_names[-1])[:3, 3]


def ball_of(model: aghf.Model, start: np.ndarray) -> Callable[[float], np.ndarray]:
    """A ball that crosses close in front of the robot and back, at up to 0.25 m/s, as a function of time."""
    x, _, z = tool(model, start)
    return lambda now: np.array([x + BESIDE, 0.6 * np.cos(0.25 / 0.6 * now), z])


def target_of(model: aghf.Model, start: np.ndarray) -> Callable[[float], np.ndarray]:
    """Two joints that swing, as a function of time, so slowly that the tool is never faster than `SPEED`."""
    swing = 0.6 * np.eye(model.dof)[0] + 0.15 * np.eye(model.dof)[3]
    phases = np.linspace(0.0, 2 * np.pi, 400)
    way = np.array([tool(model, start + np.sin(phase) * swing) for phase in phases])
    rate = SPEED / (np.linalg.norm(np.diff(way, axis=0), axis=1).max() / phases[1])
    return lambda now: start + np.sin(rate * now) * swing


def simulation(model: aghf.Model) -> tuple[mujoco.MjModel, list[tuple[int, int]]]:
    """The real robot among the obstacles, and the pairs of shapes whose distance is measured."""
    specification = specification_of(model)
    # Shapes without contacts count as visual.
    specification.compiler.discardvisual = False
    for name, size in SIZES.items():
        half = {"box": np.array(size) / 2, "cylinder": [size[0], size[-1] / 2, 0.0], "sphere": [size[0], 0.0, 0.0]}
        specification.worldbody.add_geom(
            name=name, type=TYPES[name], size=half[name], pos=PLACES[name], contype=0, conaffinity=0
        )
    specification.option.timestep = PERIOD / SUBSTEPS
    world = specification.compile()
    world.body_mass *= HEAVIER
    world.body_inertia *= HEAVIER
    order = order_of(model, world)
    world.dof_frictionloss[order] = LOSSES * model.effort_limits
    world.dof_damping[order] = LOSSES * model.effort_limits / model.velocity_limits
    moving = [i for i in range(world.ngeom) if world.geom_bodyid[i] > 0]
    return world, [(i, world.geom(name).id) for i in moving for name in SIZES]


def run(robot: str, seconds: float, observed: float) -> Loop:
    """The record of a closed loop in which target and ball are observed at a rate, Hz."""
    model, start = aghf.Model.builtin(robot), np.array(START[robot])
    ball_at, target = ball_of(model, start), target_of(model, start)
    scenario = {
        "robot": robot,
        "horizon_s": HORIZON,
        "q_start": start,
        "v_start": 0 * start,
        "q_goal": start + 0.01,
        "v_goal": 0 * start,
        "objective": {"effort": 0.0, "acceleration": 1.0},
        "obstacles": obstacles(ball_at(0.0)),
        "robot_shape": {"collision": {"excess_m": 0.025}},
        "clearance_m": {"obstacles": CLEARANCE},
    }
    tracker, (world, pairs) = aghf.Tracker(scenario, search={"degree": 8}), simulation(model)
    data, order, loop = mujoco.MjData(world), order_of(model, world), Loop()
    data.qpos[order] = start
    # Unbounded joints use no share of a limit.
    bounded = np.isfinite(model.upper - model.lower)
    lower, upper = model.lower[bounded], model.upper[bounded]
    every = max(1, round(1 / (PERIOD * observed)))
    for k in range(int(seconds / PERIOD)):
        now, q, v = k * PERIOD, data.qpos[order], data.qvel[order]
        ball = ball_at(now)
        goal = target(now + 2 / 3 * HORIZON)
        began = time.perf_counter(), time.thread_time()
        if k % every == 0:
            tracker.set_obstacles(obstacles(ball))
            tracker.set_goal(goal, HORIZON)
        step = tracker.step(q, v, now)
        loop.latency.append(time.perf_counter() - began[0])
        loop.processor.append(time.thread_time() - began[1])
        u = np.clip(step.command.u, -model.effort_limits, model.effort_limits)
        world.geom_pos[world.geom("sphere").id] = ball
        data.qfrc_applied[order] = u
        mujoco.mj_step(world, data, SUBSTEPS)
        loop.safety.append(step.safety)
        loop.deviation.append(step.deviation)
        loop.iterations, loop.plans = loop.iterations + step.iterations, loop.plans + step.replaced
        loop.error.append(float(np.linalg.norm(tool(model, q) - tool(model, target(now)))))
        loop.position.append(float(np.max(np.abs(2 * q[bounded] - lower - upper) / (upper - lower))))
        loop.velocity.append(float(np.max(np.abs(v) / model.velocity_limits)))
        loop.torque.append(float(np.max(np.abs(u) / model.effort_limits)))
        if k % 10 == 0:
            loop.clearance.append((now, min(mujoco.mj_geomDistance(world, data, i, j, 1.0, None) for i, j in pairs)))
    return loop


def main() -> bool:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--robot", choices=START, action="append")
    parser.add_argument("--observed", type=float, default=50.0, help="rate at which target and ball are seen, Hz")
    parser.add_argument("--page", type=Path, help="writes a page of the loops")
    arguments = parser.parse_args()
    loops = {}
    for robot in arguments.robot or START:
        loops[robot] = run(robot, arguments.seconds, arguments.observed)
        print(f"{robot}: " + "\n  ".join(loops[robot].figures()), flush=True)
    if arguments.page:
        write(arguments.page, f"Closed loops with MuJoCo, {arguments.seconds:g} s", loops, PERIOD)
        print(f"wrote {arguments.page}")
    return all(loop.least_clearance > 0.0 and loop.is_within_limits for loop in loops.values())


if __name__ == "__main__":
    sys.exit(int(not main()))
