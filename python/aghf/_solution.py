"""Results of solves."""

from __future__ import annotations

import html
import os
from collections.abc import Iterable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._json import read
from ._model import Model, array
from ._native import _aghf
from ._table import Table


class Samples(NamedTuple):
    """A motion at times: positions, velocities, accelerations and torques, each (T, N)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    tau: np.ndarray


class Solution:
    """The result of a solve.

    It can be pickled: reading it again needs the file of the robot at the same place, unless that is built in. The copy
    has neither a running cost and constraints of one's own nor the progress of the search.

    Attributes
    ----------
    verdict : str
        "optimal", "valid", which keeps everything but has not converged, "at s_max", the curve at the end of the
        published flow, or "not valid".
    success : bool
        True unless the motion is not valid.
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
        return from_summary, (self._own.summary_json(),)

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
        return read(self._own.summary_json())

    @cached_property
    def scenario(self) -> dict[str, Any]:
        return read(self._own.scenario_json())

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
        return read(self._own.joint_trajectory_json(rate))

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


def stack(solutions: Iterable[Solution], samples: int = 201) -> Samples:
    """The motions of solutions for robots of as many joints, as arrays for learning.

    Parameters
    ----------
    solutions : iterable of Solution
        The B motions, at least one.
    samples : int
        The number T of equidistant times of each motion, both ends included.

    Returns
    -------
    Samples
        The times, (B, T), and positions, velocities, accelerations and torques, each (B, T, N).
    """
    motions = [solution.sample(samples) for solution in solutions]
    joints = sorted({motion.q.shape[1] for motion in motions})
    if len(joints) != 1:
        raise ValueError(f"solutions: their numbers of joints are {joints} and must be one number")
    return Samples(*(np.stack(part) for part in zip(*motions, strict=True)))


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


def from_summary(summary: str) -> Solution:
    """The solution with this summary in JSON, without the progress of its search."""
    return Solution(_aghf.Solution.from_summary(summary))


def _model(summary: str) -> Model:
    """The robot of a solution that was pickled."""
    return from_summary(summary).model
