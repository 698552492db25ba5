"""Smooth programs."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ._model import array
from ._native import _aghf


class Program(Protocol):
    """The functions of a program in ``n`` unknowns with ``m`` rows, all of them dense; a program without rows needs no
    `constraints` and no `jacobian`."""

    def objective(self, x: np.ndarray) -> float:
        """The objective."""
        ...

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """The gradient of the objective, shape (n,)."""
        ...

    def constraints(self, x: np.ndarray) -> np.ndarray:
        """The rows, shape (m,)."""
        ...

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """The Jacobian of the rows, shape (m, n)."""
        ...

    def hessian(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The Hessian of the objective plus ``y`` times the rows, shape (n, n)."""
        ...


@dataclass(frozen=True)
class ProgramSolution:
    """A point with multipliers, which are positive at upper bounds.

    `status` is "Converged" if and only if each of the errors `stationarity`, `feasibility` and `complementarity` of the
    conditions of Karush, Kuhn and Tucker is at most the tolerance.
    """

    x: np.ndarray
    objective: float
    multipliers: np.ndarray
    bound_multipliers: np.ndarray
    status: str
    iterations: int
    stationarity: float
    feasibility: float
    complementarity: float


def solve_nlp(
    program: Program,
    x: ArrayLike,
    bounds: ArrayLike,
    row_bounds: ArrayLike = (),
    *,
    iterations: int = 3000,
    tolerance: float = 1e-8,
) -> ProgramSolution:
    """Finds a local minimum of a smooth program by the interior-point method that plans motions.

    Parameters
    ----------
    program : Program
        An object with the functions and their derivatives, which are evaluated within the bounds of the unknowns alone.
        A value that is not finite makes a step shorter; an exception ends the search and is raised again.
    x : (n,)
        The start, which is moved inside the bounds.
    bounds : (n, 2)
        Lower and upper bounds of the unknowns; they may be infinite, and equal ones fix an unknown.
    row_bounds : (m, 2), optional
        Lower and upper bounds of the rows; equal ones make an equality.
    iterations : int, optional
        The largest number of iterations.
    tolerance : float, optional
        The largest error of the conditions of Karush, Kuhn and Tucker, of the program scaled such that no slope is
        larger than 100 at the start.

    Raises
    ------
    ValueError
        A shape is wrong.
    InputError
        Bounds exclude each other, or the tolerance is not positive.
    """
    unknowns, rows = (np.asarray(each, dtype=float).reshape(-1, 2) for each in (bounds, row_bounds))
    found = _aghf.solve_nlp(program, array(x, "x"), unknowns, rows, iterations, tolerance)
    return ProgramSolution(**found)
