"""Aligator on the experiments of the paper with obstacles (Table VIII), beside ours."""

import functools
import itertools
import subprocess
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from common import ONE_CORE, Row, add_ours, check_dynamics, finish, percentile, robot, scenario
from dynamics.robots import joints, row
from programs import built, environment
from shooting import guess, motion_of

SECTION = "obstacles"
NOTE = (
    "ProxDDP of Aligator 0.19.1, at most 1000 iterations, with the costs, the equality at the end, the guesses and the "
    "best sets of the supplement, and an inequality for each sphere and joint frame: the radius less the distance is "
    "not positive. The supplement names no rollout: for Kinova nonlinear, the default of its time and of the example "
    "`ur5_reach`, whose penalty the best set has; for Digit linear, today's default, as the other one diverges in the "
    'first iteration. "Tuned" follows its examples: the torques that hold the start as the guess, the penalty 0.01 '
    'that is its default, like weights of state and control; "for effort" weighs the control a hundred times as much '
    "as the state. Digit falls with such torques, so its tuned set is the best one with smaller weights and steps. The "
    "limits of iterations and time are ours. Its dynamics are checked. It is compiled for any x86-64, as its wheel is, "
    "and its set-up is not timed; solves of more than 5 s are timed once. Its objective is not the effort alone. The "
    "judge is as for Crocoddyl, and its links have volumes, where the inequalities are about joint frames only."
)
FAMILIES = {
    "Kinova": [f"kinova_obstacles_{n:02}" for n in range(1, 6)],
    "Digit": ["digit_obstacles_2", "digit_obstacles_4"],
}
ITERATIONS = 1000


@dataclass(frozen=True)
class Parameters:
    """A set of Table VIII, and what the table does not have, by default as Aligator sets it."""

    w_u: float
    w_x: float
    w_xf: float
    dt: float
    tolerance: float
    mu: float
    guess: str
    nonlinear: bool = False
    regularisation: float = 1e-9

    def __str__(self):
        return (
            f"w_u {self.w_u:g} w_x {self.w_x:g} w_xf {self.w_xf:g} dt {self.dt:g} tol {self.tolerance:g} "
            f"mu {self.mu:g} {self.guess}{', nonlinear rollout' if self.nonlinear else ''}"
        )


# The best sets of the supplement; that of Digit is for errors up to 0.25, as none ended within 0.05.
BEST = {
    "Kinova": Parameters(1e-4, 1e-3, 1.0, 1e-3, 1e-3, 1e-7, "Line and RNEA", True),
    "Digit": Parameters(1e-2, 1.0, 1e-6, 1e-2, 1e-3, 1e-8, "Zeros"),
}
# After its examples: the torques that hold the start as the guess, the default penalty of its solver (as
# `ur10_ballistic`, which has a terminal equality too), weights of state and control alike (as `ur5_reach`), or more on
# the control, as effort is what is compared. Digit falls with such torques: its set is the best one on a smaller scale.
TUNED = {
    "Kinova": {
        "Aligator, tuned": Parameters(1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-2, "Rollout and Constant", True),
        "Aligator, tuned for effort": Parameters(1e-2, 1e-4, 1e-2, 1e-3, 1e-3, 1e-2, "Rollout and Constant", True),
    },
    "Digit": {"Aligator, tuned": Parameters(1e-4, 1e-2, 1e-6, 8e-4, 1e-4, 1e-8, "Zeros")},
}
GRID = [
    Parameters(*values)
    for values in itertools.product(
        [1e-5, 1e-4, 1e-3, 1e-2, 1e-1],
        [1e-6, 1e-4, 1e-3, 0.0, 1.0, 100.0, 1000.0],
        [1e-6, 1e-4, 1.0, 10.0, 1000.0],
        [1e-2, 1e-3],
        [1e-3, 1e-4, 1e-7],
        [1e-2, 1e-7, 1e-8],
        ["Zeros", "Line and RNEA", "Rollout and Zero", "Rollout and Constant"],
    )
]


@dataclass
class Solution:
    """The output of the program about a solve."""

    seconds: list
    iterations: int
    converged: bool
    fault: str = ""
    states: np.ndarray = None
    controls: np.ndarray = None


@functools.cache
def program():
    """The program that solves, with the wheels of an environment of its own."""
    return built("aligator", environment("aligator"))


def problem(model, values, parameters, states, controls, sample, limit, repeats):
    """A problem as the words that `plan.cpp` reads."""
    start, goal = (np.r_[values[f"q_{end}"], values[f"v_{end}"]] for end in ("start", "goal"))
    spheres = [[*o["pose"]["position_m"], o["shape"]["sphere"]["radius_m"]] for o in values["obstacles"]]
    p = parameters
    settings = [p.dt, p.w_u, p.w_x, p.w_xf, p.tolerance, p.mu, p.nonlinear, p.regularisation]
    settings += [ITERATIONS, limit, repeats]
    lines = [str(model.nv), *joints(model), row(sample), row(start), row(goal), str(len(spheres)), row(spheres)]
    lines += [" ".join(f"{float(x):.17g}" for x in settings), str(len(controls)), row(states), row(controls)]
    return "\n".join(lines)


def solve(model, values, parameters, limit, repeats):
    """Aligator's ProxDDP, after a check that its forward dynamics undo Pinocchio's inverse dynamics."""
    states, controls = guess(model, values, parameters.guess, parameters.dt)
    if not np.isfinite(states).all():
        return Solution([], 0, False, "the rollout diverges")
    sample = np.random.default_rng(3).normal(size=3 * model.nv)
    words = problem(model, values, parameters, states, controls, sample, limit, repeats)
    run = subprocess.run([program()], input=words, capture_output=True, text=True, check=True)
    acceleration, verdict, *knots = run.stdout.splitlines()
    q, v, u = sample.reshape(3, -1)
    back = pin.rnea(model, model.createData(), q, v, np.array(acceleration.split(), float))
    assert np.abs(back - u).max() < 1e-6 * max(1.0, np.abs(u).max()), f"{values['robot']}: Aligator has other dynamics"
    kind, iterations, *rest = verdict.split(maxsplit=3 if verdict.startswith("fault") else -1)
    if kind == "fault":
        return Solution([float(rest[0])], int(iterations), False, rest[1])
    table = np.array([line.split() for line in knots], float)
    states, controls = table[:, : 2 * model.nv], table[:-1, 2 * model.nv :]
    return Solution([float(x) for x in rest], int(iterations), kind == "converged", "", states, controls)


def add(table, family, name, method, parameters, repeats, limit):
    """A row of Aligator."""
    if table.has(SECTION, name, method, str(parameters)):
        return
    values = scenario(name)
    model = robot(values["robot"])
    check_dynamics(model, values["robot"])
    found = solve(model, values, parameters, limit, repeats)
    entry = Row(SECTION, family, name, method, str(parameters), repeats=len(found.seconds))
    entry.iterations, entry.note = found.iterations, found.fault
    entry.seconds, entry.seconds_90 = percentile(found.seconds, 0.5), percentile(found.seconds, 0.9)
    if not found.fault:
        motion = motion_of(model, found.states, found.controls, parameters.dt)
        finish(entry, values, motion, values["success_threshold"])
        entry.note = "; ".join(filter(None, [entry.note, "" if found.converged else "not converged"]))
    table.add(entry)


def run(table, options):
    """Best sets, tuned ones, and ours; with `--grid` all sets of the table too."""
    for family, names in FAMILIES.items():
        if options.quick:
            names = {"Kinova": names[:1], "Digit": []}[family]
        for name in names:
            values = scenario(name)
            tolerance = values["success_threshold"]
            for method, own in [
                ("ours", []),
                ("ours, one start", ["--starts", "1"]),
                ("ours, published flow", ["--method", "flow"]),
            ]:
                add_ours(table, SECTION, family, values, method, own, options.repeats, tolerance)
            limit = options.limit or 300
            add(table, family, name, "Aligator, best set", BEST[family], options.repeats, limit)
            for method, parameters in TUNED[family].items():
                add(table, family, name, method, parameters, options.repeats, limit)
            if options.grid:
                for parameters in GRID:
                    add(table, f"{family}, grid", name, "Aligator, grid", parameters, 1, limit)
