"""Crocoddyl on the experiments of the paper without obstacles (Table VII), beside ours."""

import itertools
import time
from dataclasses import dataclass

import crocoddyl
import numpy as np
import pinocchio as pin

from common import Row, add_ours, check_dynamics, finish, percentile, robot, scenario
from shooting import guess, motion_of

SECTION = "paper"
NOTE = (
    "Crocoddyl's FDDP, at most 500 iterations, with the costs, guesses and best sets of the supplement (of "
    'the pendulums it names none: w_u = w_x = 1e-4, w_xf = 1000, 1 ms, Zeros), and "tuned", as its examples '
    "do: the start and the torques that hold it as the guess, w_u = w_x = 1e-4, w_xf = 1000, 1 ms. Its set-up "
    "is checked: inverse dynamics are ours to 1e-9. Its objective is not the effort alone, so a larger effort "
    "is no fault of it. The judge accepts 0.05, the paper's threshold, here; of Crocoddyl, which "
    "has states at knots by semi-implicit Euler steps, it gets the motion that the simulation with feedback "
    "makes of them. Ours has degree 16 where nothing is said."
)
FAMILIES = {
    "pendulums": [f"pendulum_{n}_swingup" for n in range(1, 7)],
    "Kinova": [f"kinova_free_{n:02}" for n in range(1, 6)],
    "Digit": ["digit_free_stretch", "digit_free_step"],
}


@dataclass(frozen=True)
class Parameters:
    """A set of Table VII."""

    w_u: float
    w_x: float
    w_xf: float
    dt: float
    guess: str

    def __str__(self):
        return f"w_u {self.w_u:g} w_x {self.w_x:g} w_xf {self.w_xf:g} dt {self.dt:g} {self.guess}"


# The best sets of the supplement; of the pendulums it names none, so those are ours, the best of a few.
BEST = {
    "pendulums": Parameters(1e-4, 1e-4, 1000.0, 1e-3, "Zeros"),
    "Kinova": Parameters(1e-4, 1e-4, 1.0, 1e-4, "Zeros"),
    "Digit": Parameters(1e-4, 1e-3, 1000.0, 1e-3, "Rollout and Constant"),
}
# What its examples do: the start with the torques that hold it as the guess, a small weight of the state, a large one
# of the goal.
FINER = ["--degree", "32"]
TUNED = Parameters(1e-4, 1e-4, 1000.0, 1e-3, "Constant")
GRID = [
    Parameters(*values)
    for values in itertools.product(
        [1e-4, 1e-3, 1e-2, 1e-1],
        [1e-4, 1e-3, 1e-2, 1e-1, 0.0, 1.0, 10.0],
        [1e-4, 1.0, 10.0, 1000.0],
        [1e-2, 1e-3, 1e-4],
        ["Zeros", "Line and RNEA", "Constant"],
    )
]


def check(model, name):
    """Refuses to go on unless Crocoddyl's forward dynamics undo Pinocchio's inverse dynamics, and those are ours."""
    check_dynamics(model, name)
    state = crocoddyl.StateMultibody(model)
    costs = crocoddyl.CostModelSum(state, model.nv)
    action = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, crocoddyl.ActuationModelFull(state), costs)
    data = action.createData()
    q, v, u = np.random.default_rng(3).normal(size=(3, model.nv))
    action.calc(data, np.r_[q, v], u)
    back = pin.rnea(model, model.createData(), q, v, data.xout)
    assert np.abs(back - u).max() < 1e-6 * max(1.0, np.abs(data.xout).max()), f"{name}: Crocoddyl has other dynamics"


def shooting_problem(model, values, parameters):
    """The running cost of the supplement: weighted squares of control and state, and of the error of the last state."""
    n = model.nv
    state = crocoddyl.StateMultibody(model)
    actuation = crocoddyl.ActuationModelFull(state)
    goal = np.r_[values["q_goal"], values["v_goal"]]
    residual = lambda reference: crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelState(state, reference, n))
    running, terminal = crocoddyl.CostModelSum(state, n), crocoddyl.CostModelSum(state, n)
    running.addCost(
        "control", crocoddyl.CostModelResidual(state, crocoddyl.ResidualModelControl(state, n)), parameters.w_u
    )
    running.addCost("state", residual(np.zeros(2 * n)), parameters.w_x)
    terminal.addCost("goal", residual(goal), parameters.w_xf)
    step = lambda costs, dt: crocoddyl.IntegratedActionModelEuler(
        crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs), dt
    )
    count = round(values["horizon_s"] / parameters.dt)
    start = np.r_[values["q_start"], values["v_start"]]
    problem = crocoddyl.ShootingProblem(start, [step(running, parameters.dt)] * count, step(terminal, 0.0))
    problem.nthreads = 1
    return problem


class TooLong(Exception):
    """The time limit of a set."""


class Limit(crocoddyl.CallbackAbstract):
    """Stops a solver at its next iteration after some seconds."""

    def __init__(self, seconds):
        super().__init__()
        self.end = time.perf_counter() + seconds

    def __call__(self, solver):
        if time.perf_counter() > self.end:
            raise TooLong


def solve(model, values, parameters, limit, iterations=500):
    """Crocoddyl's FDDP: the solver, whether it converged, the seconds, and whether they were too many."""
    problem = shooting_problem(model, values, parameters)
    solver = crocoddyl.SolverFDDP(problem)
    solver.setCallbacks([Limit(limit)])
    states, controls = guess(model, values, parameters.guess, parameters.dt)
    if not np.isfinite(states).all():
        return solver, False, 0.0, "the rollout diverges"
    began = time.perf_counter()
    try:
        converged, fault = solver.solve(list(states), list(controls), iterations, False), ""
    except TooLong:
        converged, fault = False, f"more than {limit:g} s"
    return solver, converged, time.perf_counter() - began, fault


def add(table, family, name, method, parameters, repeats, limit):
    """A row of Crocoddyl."""
    if table.has(SECTION, name, method, str(parameters)):
        return
    values = scenario(name)
    model = robot(values["robot"])
    check(model, values["robot"])
    solver, converged, seconds, fault = solve(model, values, parameters, limit)
    times = [seconds]
    while len(times) < repeats and seconds < 5.0 and not fault:
        times.append(solve(model, values, parameters, limit)[2])
    row = Row(SECTION, family, name, method, str(parameters), repeats=len(times), iterations=solver.iter, note=fault)
    row.seconds, row.seconds_90 = percentile(times, 0.5), percentile(times, 0.9)
    if not fault:
        motion = motion_of(model, np.array(solver.xs), np.array(solver.us), parameters.dt)
        finish(row, values, motion, values["success_threshold"])
        row.note = "; ".join(filter(None, [row.note, "" if converged else "not converged"]))
    table.add(row)


def run(table, options):
    """Best sets, tuned ones, and ours; with `--grid` all sets of the table too."""
    for family, names in FAMILIES.items():
        if options.quick:
            names = {"pendulums": names[:2], "Kinova": names[:1], "Digit": []}[family]
        for name in names:
            values = scenario(name)
            tolerance = values["success_threshold"]
            add_ours(table, SECTION, family, values, "ours", [], options.repeats, tolerance)
            add_ours(table, SECTION, family, values, "ours, one start", ["--starts", "1"], options.repeats, tolerance)
            add_ours(table, SECTION, family, values, "ours, degree 32", FINER, options.repeats, tolerance)
            if name != "pendulum_6_swingup":
                add_ours(
                    table,
                    SECTION,
                    family,
                    values,
                    "ours, published flow",
                    ["--method", "flow"],
                    options.repeats,
                    tolerance,
                )
            limit = options.limit or (180 if family == "pendulums" else 300)
            add(table, family, name, "Crocoddyl, best set", BEST[family], options.repeats, limit)
            add(table, family, name, "Crocoddyl, tuned", TUNED, options.repeats, limit)
            if options.grid:
                for parameters in GRID:
                    add(table, f"{family}, grid", name, "Crocoddyl, grid", parameters, 1, limit)
