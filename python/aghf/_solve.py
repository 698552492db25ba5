"""Solving scenarios."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ._native import _aghf
from ._model import Model, array
from ._table import Table
from ._verify import Constraint, RunningCost


class Samples(NamedTuple):
    """A motion at times: positions, velocities, accelerations and torques, each (T, N)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    tau: np.ndarray


class Solution:
    """The result of a solve.

    Attributes
    ----------
    verdict : str
        "optimal", "valid", which keeps everything but has not converged, or "not valid".
    success : bool
        True if the motion is valid.
    horizon : float
        The duration of the motion, s.
    summary : dict
        The contents of summary.json as written by `aghf solve`.
    scenario : dict
        The solved scenario.
    minima : list of dict
        For the direct method: the costs of the minima, with the number of starts that led to each.
    """

    def __init__(self, own: _aghf.Solution) -> None:
        self._own = own

    @property
    def verdict(self) -> str:
        return self._own.verdict

    @property
    def success(self) -> bool:
        return self._own.success

    @property
    def horizon(self) -> float:
        return self._own.horizon

    @cached_property
    def model(self) -> Model:
        return Model(self._own.model)

    @cached_property
    def summary(self) -> dict:
        return json.loads(self._own.summary_json())

    @cached_property
    def scenario(self) -> dict:
        return json.loads(self._own.scenario_json())

    @property
    def minima(self) -> list[dict]:
        return self.summary.get("minima", [])

    def evaluate(self, t) -> Samples:
        """The motion at times within ``[0, horizon]``, shape () or (T,), s."""
        times = array(t, "t")
        return Samples(times, *self._own.evaluate(times))

    def sample(self, count: int = 201) -> Samples:
        """The motion at this number of equidistant times, both ends included."""
        return self.evaluate(np.linspace(0.0, self.horizon, count))

    def to_joint_trajectory(self, rate: float | None = None) -> dict:
        """The motion in the shape of a ``trajectory_msgs/JointTrajectory``.

        The points are at this rate, Hz, or as many as `aghf judge` needs.
        """
        return json.loads(self._own.joint_trajectory_json(rate))

    def save(self, path: str | os.PathLike, *, rate: float | None = None, replace: bool = False) -> list[str]:
        """Writes the motion to a file ending in .mcap, which Foxglove, rerun and `ros2 bag` open, at this rate, Hz, by
        default 100, or all files of the solve into a folder; returns their paths."""
        path = os.fspath(path)
        if path.endswith(".mcap"):
            self._own.save_mcap(path, rate, replace)
            return [path]
        if rate is not None:
            raise ValueError("rate: it belongs to a file ending in .mcap")
        return self._own.save(path, replace)

    def report_html(self) -> str:
        """The page of the motion: HTML that needs no network and no other file."""
        return self._own.report_html()

    def _repr_html_(self) -> str:
        return _frame(self.report_html())

    def __repr__(self) -> str:
        effort = self.summary["control_effort"]
        return f"Solution('{self.summary['scenario']}', {self.verdict}, {self.horizon:.4g} s, effort {effort:.4g})"


class Tradeoff:
    """The least effort of a scenario at several durations.

    Attributes
    ----------
    solutions : list of Solution
        The motions by their durations, from that of least time to that of least effort.
    table : Table
        The duration, s, the control effort and the verdict of each.
    """

    def __init__(self, solutions: list[Solution]) -> None:
        self.solutions = solutions
        self.table = Table.from_rows(
            {
                "duration_s": each.horizon,
                "control_effort": each.summary["control_effort"],
                "verdict": each.verdict,
            }
            for each in solutions
        )

    def report_html(self) -> str:
        """The page of the curve, on which a click chooses the motion."""
        return _aghf.tradeoff_html([each._own for each in self.solutions])

    def _repr_html_(self) -> str:
        return _frame(self.report_html())


def _frame(page: str) -> str:
    page = html.escape(page, quote=True)
    return f'<iframe srcdoc="{page}" style="width: 100%; height: 46rem; border: 0"></iframe>'


def _named(scenario) -> tuple[str, str | None]:
    """The name and the text of a scenario; a built-in one or one in a file has no text."""
    if isinstance(scenario, Mapping):
        return "scenario", json.dumps(scenario, default=_plain)
    return os.fspath(scenario), None


def _plain(x):
    if isinstance(x, (np.ndarray, np.generic)):
        return x.tolist()
    raise TypeError(f"'{type(x).__name__}' is no part of a scenario")


def _options(options: Mapping) -> str:
    return json.dumps(options, default=_plain)


def solve(
    scenario: str | os.PathLike | Mapping,
    *,
    running_cost: RunningCost | None = None,
    constraints: Iterable[Constraint] = (),
    on_iteration: Callable[[dict], None] | None = None,
    start: Solution | None = None,
    **options,
) -> Solution:
    """Solves a scenario. Ctrl-C ends the search with the best motion so far.

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        A built-in or generated scenario by its name, the path of a file, or the keys of a scenario.
    running_cost : RunningCost, optional
        Replaces the running cost of the scenario; see `check_cost`. Only for the direct method.
    constraints : iterable of Constraint, optional
        Enforced in addition to those of the scenario, also for success; see `check_constraint`.
    on_iteration : callable, optional
        Called with a dict of each iteration; an exception ends the search.
    start : Solution, optional
        A motion of the same joints from which the search starts, with its multipliers if the constraints are as many.
        Goal, obstacles and limits may be others. Only for the direct method.
    **options
        The options of `aghf solve`: ``method``, ``degree``, ``segments``, ``tolerance``, ``starts``, ``seed``,
        ``planned_starts``, ``threads``, ``time_limit_s`` and so on.

    Raises
    ------
    InputError
        Names the file, the key and the fault.
    """
    named = _named(scenario)
    own = start._own if start is not None else None
    return Solution(_aghf.solve(named, _options(options), running_cost, list(constraints), on_iteration, own))


def solve_many(
    scenarios: Iterable[str | os.PathLike | Mapping], *, threads: int | None = None, **options
) -> list[Solution]:
    """Solves scenarios in parallel, one per core or on this number of threads.

    The results are in the order of the scenarios and do not depend on the number of threads.
    """
    named = [_named(scenario) for scenario in scenarios]
    return [Solution(own) for own in _aghf.solve_many(named, _options(options), threads)]


def tradeoff(scenario: str | os.PathLike | Mapping, *, points: int = 20, **options) -> Tradeoff:
    """Finds motions from the least duration to the least effort, each from the one before. Ctrl-C raises.

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        As for `solve`; its objective has no effect.
    points : int
        The number of motions.
    **options
        The options of `aghf solve` for the direct method.
    """
    name, text = _named(scenario)
    found = _aghf.tradeoff(name, text, _options(options), points)
    return Tradeoff([Solution(own) for own in found])


def sweep(name: str | os.PathLike, *, threads: int | None = None) -> Table:
    """Solves scenarios with every combination of parameters of a grid, on all cores or this number of threads.

    Parameters
    ----------
    name : str or os.PathLike
        A built-in sweep, a TOML file, or a folder of scenarios. Only `aghf sweep` on the command line can resume.

    Returns
    -------
    Table
        A row per solve: the scenario, its parameters, the outcome, and the measurements.
    """
    return Table.from_rows(json.loads(_aghf.sweep(os.fspath(name), threads)))
