#!/usr/bin/env python3
"""Measures a tracker: steps by problem size, and solves after a goal has moved, warm and cold, beside Crocoddyl's FDDP.

    pip install ./python numpy crocoddyl pin
    python3 benches/tracker.py --count 200 --deadlines 10000

Deadlines: the processor time of a step beyond its deadline, on a moving goal among obstacles of which one moves; and
the judgement of the plan after each step that was cut off, from where it is to its end, among the obstacles then.
Steps: the processor time of a step with its iteration and its look, after the first search, at 500 Hz with a goal that
moves every 20 ms; the first search is the cold solve. Cases: random reaches of the Kinova arm within all limits and
around a ball, the tool of whose goal is then moved by 1 cm; "warm" starts from the solution before, both to the
default tolerance of 1e-6; "tracker" is the number of iterations to a plan to the new goal that keeps all rows. FDDP
has the same ends and effort without limits and ball, with semi-implicit Euler steps of 10 ms and a terminal weight of
1000, on the first 20 cases, and starts from the solution before or from rest.
"""

import argparse
import time

import crocoddyl
import numpy as np
import pinocchio as pin

import aghf

STARTS = {
    "pendulum_2": [0.0, 0.0],
    "kinova_gen3": [0.0, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0],
    "panda": [0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.785],
}
OBSTACLES = [
    {"shape": {"box": {"size_m": [0.5, 0.8, 0.04]}}, "pose": {"position_m": [0.6, 0.0, 0.0]}},
    {"shape": {"cylinder": {"radius_m": 0.05, "length_m": 0.6}}, "pose": {"position_m": [-0.45, 0.3, 0.3]}},
    {"shape": {"sphere": {"radius_m": 0.08}}, "pose": {"position_m": [0.6, 0.6, 0.5]}},
]
SIZES = {
    "limits": {"self_collision": "off"},
    "limits, links": {},
    "limits, links, three obstacles": {"obstacles": OBSTACLES},
}
STEP, TERMINAL, WEIGHT, HORIZON, FDDP_CASES = 0.01, 1000.0, 1e-3, 2.0, 20


def reach(robot: str, start, goal, horizon: float, **others) -> dict:
    start, goal = np.array(start), np.array(goal)
    shape = {"robot_shape": {"collision": {"excess_m": 0.025}}} if robot != "pendulum_2" else {}
    ends = {"q_start": start, "v_start": 0 * start, "q_goal": goal, "v_goal": 0 * goal}
    return {"robot": robot, "horizon_s": horizon, **ends, **shape, **others}


def steps() -> None:
    print("robot, rows, degree: first search ms, step ms (median, 99 %)")
    for robot, start in STARTS.items():
        for rows, others in SIZES.items() if robot != "pendulum_2" else [("limits", {})]:
            for degree in (8, 12):
                goal = np.array(start) + 0.5 * np.eye(len(start))[0]
                began = time.process_time()
                search = {"degree": degree, "threads": 1}
                tracker = aghf.Tracker(reach(robot, start, goal, 1.0, **others), search=search)
                first, times = time.process_time() - began, []
                q, v = np.array(start), 0 * goal
                for k in range(1000):
                    if k % 10 == 0:
                        goal[0] += 0.003
                        tracker.set_goal(goal, 0.6)
                    began = time.thread_time()
                    command = tracker.step(q, v, 0.002 * k).command
                    times.append(1e3 * (time.thread_time() - began))
                    q, v = command.q, command.v
                median, high = np.quantile(times, [0.5, 0.99])
                print(f"{robot}, {rows}, {degree}: {1e3 * first:.0f}, {median:.2f}, {high:.2f}", flush=True)


class Fddp:
    """Crocoddyl on a reach."""

    def __init__(self, model: aghf.Model, start: np.ndarray, goal: np.ndarray):
        self.own = pin.buildModelFromXML(model.to_urdf())
        # Unbounded joints have a cosine and a sine in Pinocchio, which the states of Crocoddyl take care of.
        ends = [aghf.pinocchio_configuration(self.own, q) for q in (start, goal)]
        self.start, self.goal = (np.concatenate([q, np.zeros(model.dof)]) for q in ends)
        self.state = crocoddyl.StateMultibody(self.own)
        actuation = crocoddyl.ActuationModelFull(self.state)

        def action(residual, weight: float, step: float):
            costs = crocoddyl.CostModelSum(self.state)
            costs.addCost("cost", crocoddyl.CostModelResidual(self.state, residual), weight)
            free = crocoddyl.DifferentialActionModelFreeFwdDynamics(self.state, actuation, costs)
            return crocoddyl.IntegratedActionModelEuler(free, step)

        count = round(HORIZON / STEP)
        running = action(crocoddyl.ResidualModelControl(self.state), WEIGHT, STEP)
        last = action(crocoddyl.ResidualModelState(self.state, self.goal, model.dof), TERMINAL, 0.0)
        problem = crocoddyl.ShootingProblem(self.start, [running] * count, last)
        problem.nthreads = 1
        self.solver = crocoddyl.SolverFDDP(problem)
        self.hold = pin.computeGeneralizedGravity(self.own, self.own.createData(), ends[0])

    def solve(self, guess: "Fddp | None") -> tuple[int, float]:
        """The number of iterations and the time, ms."""
        count = self.solver.problem.T
        states, controls = [self.start] * (count + 1), [self.hold] * count
        if guess is not None:
            states, controls = guess.solver.xs.tolist(), guess.solver.us.tolist()
        self.solver.th_stop = 1e-6
        began = time.thread_time()
        self.solver.solve(states, controls, 500, False)
        return self.solver.iter, 1e3 * (time.thread_time() - began)


def tracked(before: dict, goal: np.ndarray) -> int:
    """The iterations of a tracker after its goal has moved."""
    tracker = aghf.Tracker(before, search={"threads": 1})
    q = np.array(before["q_start"])
    for k in range(100):
        tracker.step(q, 0 * q, 0.0)
    tracker.set_goal(goal, HORIZON)
    count = 0
    while count < 200:
        step = tracker.step(q, 0 * q, 0.0)
        count += step.iterations
        if step.replaced:
            break
    return count


def deadlines(count: int) -> None:
    """Random deadlines, from too short for an iteration to more than enough, with a goal and a ball that move."""
    rng, start = np.random.default_rng(10), np.array(STARTS["kinova_gen3"])
    goal = start + 0.5 * np.eye(len(start))[0]
    problem = reach("kinova_gen3", start, goal, 1.0, obstacles=OBSTACLES)
    tracker, (q, v), late, cut, kept = aghf.Tracker(problem, search={"threads": 1}), (start, 0 * start), [], 0, 0
    judged = {True: 0, False: 0}
    for k in range(count):
        if k % 10 == 0:
            tracker.set_goal(goal + 0.3 * np.sin(1e-3 * k) * np.eye(len(start))[0], 0.6)
            ball = {**OBSTACLES[-1], "pose": {"position_m": [0.6, 0.6, 0.5 + 0.05 * np.sin(1e-3 * k)]}}
            obstacles = [*OBSTACLES[:-1], ball]
            tracker.set_obstacles(obstacles)
        deadline = rng.uniform(0.3e-3, 3e-3)
        tracker.set_deadline(deadline)
        began = time.thread_time()
        step = tracker.step(q, v, 0.002 * k)
        late.append(1e3 * (time.thread_time() - began - deadline))
        q, v = step.command.q, step.command.v
        cut, kept = cut + step.cut_off, kept + (step.safety == "kept")
        if step.cut_off and step.safety == "kept":
            rest = tracker.rest(401)
            ends = {"q_start": rest.q[0], "v_start": rest.v[0], "q_goal": rest.q[-1], "v_goal": 0 * start}
            own = {**problem, **ends, "horizon_s": rest.t[-1], "obstacles": obstacles}
            judged[aghf.judge(own, *rest)["valid"]] += 1
    over = np.mean(np.array(late) > 0.2)
    print(f"{count} deadlines of 0.3 to 3 ms: later by more than 0.2 ms {over:.2%}, at most {max(late):.2f} ms late")
    print(f"cut off {cut / count:.1%}, safe plan {kept / count:.1%}")
    print(f"plans of cut-off steps that are reported as safe: {judged[True]} valid by the judge, {judged[False]} not")


def moved(count: int) -> None:
    model, rng, rows = aghf.Model.builtin("kinova_gen3"), np.random.default_rng(39), []
    start, goal = np.array(STARTS["kinova_gen3"]), np.array([1.2, 0.9, 0.0, 1.2, 0.0, 0.8, 0.0])
    ball = {"shape": {"sphere": {"radius_m": 0.1}}, "pose": {"position_m": [0.3, 0.4, 0.5]}}
    others = {"robot_shape": "joint_frames", "obstacles": [ball]}
    while len(rows) < count:
        a, b = (q + rng.uniform(-0.3, 0.3, model.dof) for q in (start, goal))
        jacobian = aghf.frame_jacobian(model, b, model.frame_names[-1])[3:]
        direction = rng.normal(size=3)
        c = b + np.linalg.pinv(jacobian) @ (0.01 * direction / np.linalg.norm(direction))
        before, after = ({**reach("kinova_gen3", a, end, HORIZON), **others} for end in (b, c))
        try:
            known = aghf.solve(before, threads=1)
            cold, warm = aghf.solve(after, threads=1), aghf.solve(after, start=known, threads=1)
            own = tracked(before, c)
        except aghf.InputError:
            # An end is within the ball, or no plan is found.
            continue
        if not (known.success and cold.success):
            continue
        fddp = [np.nan] * 4
        if len(rows) < FDDP_CASES:
            first, second = Fddp(model, a, b), Fddp(model, a, c)
            first.solve(None)
            fddp = [*second.solve(None), *second.solve(first)]
        iterations = [each.summary["iterations"] for each in (cold, warm)]
        costs = [each.summary["cost"] for each in (cold, warm)]
        rows.append([*iterations, own, costs[1] / costs[0], *fddp])
    rows = np.array(rows)
    for name, column in (("cold", 0), ("warm", 1), ("tracker", 2), ("FDDP cold", 4), ("FDDP warm", 6)):
        median, high = np.nanquantile(rows[:, column], [0.5, 0.95])
        print(f"{name}: {median:.0f} iterations in the median, {high:.0f} in 95 %")
    for name, column in (("warm", 1), ("tracker", 2)):
        ratio = rows[:, column] / rows[:, 0]
        print(f"{name} / cold: {np.median(ratio):.3f} in the median, at most a tenth in {np.mean(ratio <= 0.1):.1%}")
    print(f"warm costs at most as much as cold, to 1e-3, in {np.mean(rows[:, 3] <= 1.001):.1%}")
    print(f"FDDP: {np.nanmedian(rows[:, 5]):.0f} ms cold, {np.nanmedian(rows[:, 7]):.0f} ms warm")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--deadlines", type=int, default=10_000)
    arguments = parser.parse_args()
    deadlines(arguments.deadlines)
    steps()
    moved(arguments.count)


if __name__ == "__main__":
    main()
