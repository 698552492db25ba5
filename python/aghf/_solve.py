"""Solving scenarios."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from ._native import _aghf
from ._model import Model, array
from ._table import Table
from ._verify import Constraint, RunningCost

if TYPE_CHECKING:
    from typing_extensions import Unpack

InputError = _aghf.InputError


Method = Literal["direct", "flow", "rest", "duals", "two_phases"]
PlannedStarts = Literal["later", "first", "never"]
Guess = Literal["line_configuration", "line_state"]
Integrator = Literal["bdf", "esdirk34"]


class Options(TypedDict, total=False):
    """The options of `solve` that are those of `aghf solve`."""

    method: Method | None
    degree: int | None
    segments: int | None
    degree_tolerance: float | None
    tolerance: float | None
    reserve: float | None
    starts: int | None
    seed: int | None
    planned_starts: PlannedStarts | None
    time_limit_s: float | None
    k: float | None
    s_max: float | None
    guess: Guess | None
    jacobian: str | None
    integrator: Integrator | None
    k_cons: float | None
    c_cons: float | None


class Samples(NamedTuple):
    """A motion at times: positions, velocities, accelerations and torques, each (T, N)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    tau: np.ndarray


class Solution:
    """The result of a solve.

    It can be pickled: what reads it again needs the file of the robot at the same place, unless that is built in, and
    has neither a running cost and constraints of one's own nor the progress of the search.

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
    model : Model
        Its robot, without locked joints.
    minima : list of dict
        For the direct method: the costs of the minima, with the number of starts that led to each.
    """

    def __init__(self, own: _aghf.Solution) -> None:
        self._own = own

    def __reduce__(self) -> tuple[Any, ...]:
        return _solution, (self._own.summary_json(),)

    def __copy__(self) -> Solution:
        return Solution(self._own)

    def __deepcopy__(self, memo: object) -> Solution:
        return Solution(self._own)

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
        return Model(self._own.model, (_model, (self._own.summary_json(),)))

    @cached_property
    def summary(self) -> dict[str, Any]:
        return _read(self._own.summary_json())

    @cached_property
    def scenario(self) -> dict[str, Any]:
        return _read(self._own.scenario_json())

    @property
    def minima(self) -> list[dict[str, Any]]:
        minima: list[dict[str, Any]] = self.summary.get("minima", [])
        return minima

    def evaluate(self, t: ArrayLike) -> Samples:
        """The motion at times within ``[0, horizon]``, shape () or (T,), s."""
        times = array(t, "t")
        return Samples(times, *self._own.evaluate(times))

    def sample(self, count: int = 201) -> Samples:
        """The motion at this number of equidistant times, both ends included."""
        return self.evaluate(np.linspace(0.0, self.horizon, count))

    def to_joint_trajectory(self, rate: float | None = None) -> dict[str, Any]:
        """The motion in the shape of a ``trajectory_msgs/JointTrajectory``.

        The points are at this rate, Hz, or as many as `aghf judge` needs.
        """
        return _read(self._own.joint_trajectory_json(rate))

    def save(self, path: str | os.PathLike[str], *, rate: float | None = None, replace: bool = False) -> list[str]:
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


def _read(text: str) -> dict[str, Any]:
    """The object of a text in JSON."""
    read: dict[str, Any] = json.loads(text)
    return read


def _solution(summary: str) -> Solution:
    """The solution that was pickled."""
    return Solution(_aghf.Solution.from_summary(summary))


def _model(summary: str) -> Model:
    """The robot of a solution that was pickled."""
    return _solution(summary).model


def _named(scenario: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[str, str | None]:
    """The name and the text of a scenario; a built-in one or one in a file has no text."""
    if isinstance(scenario, Mapping):
        return "scenario", json.dumps(scenario, default=_plain)
    return os.fspath(scenario), None


def _plain(x: object) -> Any:
    if isinstance(x, (np.ndarray, np.generic)):
        return x.tolist()
    raise TypeError(f"'{type(x).__name__}' is no part of a scenario")


def _options(**options: object) -> str:
    """The options that were given."""
    given = {name: value for name, value in options.items() if value is not None}
    return json.dumps(given, default=_plain)


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
        A motion of the same joints from which the search starts, with its multipliers if the constraints are as many.
        Goal, obstacles and limits may be others. Only for the direct method.
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
    options = _options(
        method=method,
        degree=degree,
        segments=segments,
        degree_tolerance=degree_tolerance,
        tolerance=tolerance,
        reserve=reserve,
        starts=starts,
        seed=seed,
        planned_starts=planned_starts,
        threads=threads,
        time_limit_s=time_limit_s,
        k=k,
        s_max=s_max,
        guess=guess,
        jacobian=jacobian,
        integrator=integrator,
        k_cons=k_cons,
        c_cons=c_cons,
    )
    own = start._own if start is not None else None
    return Solution(_aghf.solve(_named(scenario), options, running_cost, list(constraints), on_iteration, own))


def solve_many(
    scenarios: Iterable[str | os.PathLike[str] | Mapping[str, Any]],
    *,
    threads: int | None = None,
    **options: Unpack[Options],
) -> list[Solution | Exception]:
    """Solves scenarios in parallel, one per core or on this number of threads.

    The results are in the order of the scenarios and do not depend on the number of threads. A scenario that is refused
    has its exception in the list, such as an `InputError`. Ctrl-C ends all searches with the best motions so far; each
    scenario that had not begun then has an `InputError`.

    Parameters
    ----------
    scenarios : iterable
        Scenarios as for `solve`.
    threads : int, optional
        The number of scenarios that are solved at the same time, by default one per core.
    **options
        The options of `solve` for each of them, without its ``threads``.
    """
    named = [_named(scenario) for scenario in scenarios]
    found = _aghf.solve_many(named, _options(**options), threads)
    return [own if isinstance(own, Exception) else Solution(own) for own in found]


def tradeoff(
    scenario: str | os.PathLike[str] | Mapping[str, Any], *, points: int = 20, **options: Unpack[Options]
) -> Tradeoff:
    """Finds motions from the least duration to the least effort, each from the one before. Ctrl-C raises.

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        As for `solve`; its objective has no effect.
    points : int
        The number of motions.
    **options
        The options of `solve` for the direct method.
    """
    name, text = _named(scenario)
    found = _aghf.tradeoff(name, text, _options(**options), points)
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
