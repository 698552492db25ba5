"""Solving scenarios."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal

from ._json import given, named
from ._native import _aghf
from ._solution import Samples as Samples
from ._solution import Solution as Solution
from ._solution import Tradeoff as Tradeoff
from ._table import Table
from ._verify import Constraint, RunningCost

InputError = _aghf.InputError


Method = Literal["direct", "flow", "rest", "duals", "two_phases"]
PlannedStarts = Literal["later", "first", "never"]
Guess = Literal["line_configuration", "line_state"]
Integrator = Literal["bdf", "esdirk34"]


def solve(
    scenario: str | os.PathLike[str] | Mapping[str, Any],
    *,
    running_cost: RunningCost | None = None,
    constraints: Iterable[Constraint] = (),
    on_iteration: Callable[[dict[str, Any]], object] | None = None,
    start: Solution | None = None,
    method: Method | None = None,
    degree: int | None = None,
    segments: int | None = None,
    degree_tolerance: float | None = None,
    tolerance: float | None = None,
    reserve: float | None = None,
    starts: int | None = None,
    seed: int | None = None,
    planned_starts: PlannedStarts | None = None,
    threads: int | None = None,
    time_limit_s: float | None = None,
    k: float | None = None,
    s_max: float | None = None,
    guess: Guess | None = None,
    jacobian: str | None = None,
    integrator: Integrator | None = None,
    k_cons: float | None = None,
    c_cons: float | None = None,
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
        A motion of the same joints from which the search starts, with its multipliers if the number of constraints is
        the same. Goal, obstacles and limits may differ. Only for the direct method.
    method : {"direct", "flow", "rest", "duals", "two_phases"}, optional
        The method, by default "direct". Each has some of the other options, with defaults of its own;
        ``aghf scenarios --keys options`` lists them.
    degree : int, optional
        The degree of the polynomial, or of each segment.
    segments : int, optional
        The number of polynomials on equal parts of the horizon.
    degree_tolerance : float, optional
        The relative change of the effort between two degrees at which the degree stops growing.
    tolerance : float, optional
        The relative norm of the gradient at the end; for "flow" the tolerance of the integrator.
    reserve : float, optional
        The distance from limits and obstacles, relative to the limit.
    starts, seed : int, optional
        The number of starts, and the seed of those that are drawn.
    planned_starts : {"later", "first", "never"}, optional
        Starts that follow planned paths around obstacles.
    threads : int, optional
        The number of threads for the starts, with the same result.
    time_limit_s : float, optional
        The time after which the search ends with the best motion so far, s; a flow fails then.
    k : float, optional
        The penalty of (11) on velocities that differ from those of the curve, for all flows.
    s_max, guess, jacobian, integrator, k_cons, c_cons : optional
        For "flow": where it stops, its initial curve, its Jacobian (`jacobians`) and integrator, and the weight and
        sharpness of the constraints in (A2) and (A3).

    Raises
    ------
    InputError
        Names the file, the key and the fault.
    """
    options = given(locals(), "scenario", "running_cost", "constraints", "on_iteration", "start")
    own = start._own if start is not None else None
    callbacks = on_iteration, None
    return Solution(_aghf.solve(named(scenario), options, running_cost, list(constraints), callbacks, own))


def tradeoff(
    scenario: str | os.PathLike[str] | Mapping[str, Any],
    *,
    points: int = 20,
    degree: int | None = None,
    segments: int | None = None,
    degree_tolerance: float | None = None,
    tolerance: float | None = None,
    reserve: float | None = None,
    starts: int | None = None,
    seed: int | None = None,
    planned_starts: PlannedStarts | None = None,
    threads: int | None = None,
    time_limit_s: float | None = None,
) -> Tradeoff:
    """Finds motions from the least duration to the least effort, each from the one before. Ctrl-C raises.

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        As for `solve`; its objective has no effect.
    points : int
        The number of motions.
    degree, segments, ... : optional
        The options of `solve` for the direct method.
    """
    options = given(locals(), "scenario", "points")
    found = _aghf.tradeoff(*named(scenario), options, points)
    return Tradeoff([Solution(own) for own in found])


def sweep(name: str | os.PathLike[str], *, threads: int | None = None) -> Table:
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
