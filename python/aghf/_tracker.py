"""A motion that is followed and replanned."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._json import given, named, text
from ._model import array
from ._native import _aghf
from ._solution import Samples


class Command(NamedTuple):
    """The command at a time: the state of the plan, its acceleration and torque, each (N,); the torque to apply at the
    measured state, ``u = tau - gain @ (x - x_plan)`` with ``x = [q, v]``; and the gain, (N, 2N)."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    tau: np.ndarray
    u: np.ndarray
    gain: np.ndarray


class Violation(NamedTuple):
    """The row that a plan violates most: its name, the amount in its unit, and the time until then, s."""

    row: str
    by: float
    unit: str
    after_s: float


class Step(NamedTuple):
    """The result of a step.

    Attributes
    ----------
    outcome : str
        "working", or "finished" once the plan has ended at the goal.
    command : Command
        The command for now.
    safety : str
        "kept" if the rest of the plan keeps all current rows, "violated", or "left" if the robot is far from it.
    violation : Violation or None
        The violated row.
    deviation : float
        The largest distance of a joint from the plan, rad or m.
    iterations : int
        The number of iterations of the search.
    replaced, cut_off, converged : bool
        True if the plan is a new one; if the deadline ended the search; if further iterations would change nothing.
    """

    outcome: str
    command: Command
    safety: str
    violation: Violation | None
    deviation: float
    iterations: int
    replaced: bool
    cut_off: bool
    converged: bool


class Tracker:
    """A motion to a goal that is followed and replanned at the same time, as the goal and the obstacles move.

    The plan that is followed ends at rest and keeps all rows of the scenario as long as `Step.safety` is "kept".

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        As for `solve`; it ends at rest at a configuration, and all of its joints have motors.
    search : Mapping
        The options of `solve` for the first search by the direct method; the degree, 12 by default, is that of all
        plans.
    barrier : float, optional
        The barrier parameter after the first search, relative to the objective; by default 0.01.
    iterations_per_step : int, optional
        The largest number of iterations per step; by default 1.
    least_gain : float, optional
        The least relative decrease of the objective for which a plan to the same goal replaces the old one; by default
        0.001.
    look : int, optional
        The number of intervals of the check of a plan per degree of its polynomial; by default 10.
    deadline_s : float, optional
        The time within which a step returns, s; by default there is none.
    bandwidth : float, optional
        The bandwidth of the feedback, rad/s; by default 30.
    shortest_horizon_s : float, optional
        The shortest remaining time for which a plan is changed, s; by default 0.1.
    largest_deviation : float, optional
        The distance of a joint from the plan, rad or m, beyond which a new plan begins at the measured state; by
        default 0.1.

    Raises
    ------
    InputError
        The scenario cannot be tracked, or the search finds no motion that keeps all rows.
    ValueError
        Names an option and its fault.
    """

    def __init__(
        self,
        scenario: str | os.PathLike[str] | Mapping[str, Any],
        *,
        search: Mapping[str, Any] | None = None,
        barrier: float | None = None,
        iterations_per_step: int | None = None,
        least_gain: float | None = None,
        look: int | None = None,
        deadline_s: float | None = None,
        bandwidth: float | None = None,
        shortest_horizon_s: float | None = None,
        largest_deviation: float | None = None,
    ) -> None:
        options = given({**locals(), "search": search or {}}, "self", "scenario")
        self._own = _aghf.Tracker(named(scenario), options)

    def step(self, q: ArrayLike, v: ArrayLike, now: float) -> Step:
        """Improves the plan as far as the options allow; returns the command for now.

        ``q`` and ``v``, each (N,), are the measured state; ``now`` is the time, s, not before that of the last step.
        """
        finished, command, violation, left, *others, flags = self._own.step(array(q, "q"), array(v, "v"), now)
        return Step(
            "finished" if finished else "working",
            Command(*command),
            "left" if left else "violated" if violation else "kept",
            Violation(*violation) if violation else None,
            *others,
            *flags,
        )

    def rest(self, count: int = 201) -> Samples:
        """The rest of the plan after the last step at this number of equidistant times, the first of them now."""
        times = np.linspace(0.0, self._own.left(), count)
        return Samples(times, *self._own.evaluate(times))

    def set_goal(self, q: ArrayLike, horizon_s: float) -> None:
        """Changes the goal to a configuration at rest, (N,), to be reached within a horizon, s.

        The old plan is followed until one to the new goal is safe."""
        self._own.set_goal(array(q, "q"), horizon_s)

    def set_deadline(self, seconds: float | None) -> None:
        """Changes the time within which the next steps return, s; with None there is no limit."""
        self._own.set_deadline(seconds)

    def set_obstacles(self, obstacles: Iterable[Mapping[str, Any]]) -> None:
        """Replaces all obstacles, in the form of a scenario, from the next step on; they are assumed to stand still."""
        self._own.set_obstacles(text(list(obstacles)))
