"""Checks of derivatives."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ._dynamics import rnea
from ._model import Model
from ._native import _aghf
from ._table import Table

#: The step of a complex step, whose error is that of rounding.
_COMPLEX = 1e-100
#: The step of a central difference in numbers about 1, and the largest relative error of one.
_STEP = 1e-6
_BOUND = {"complex step": 1e-9, "central difference": 1e-5}


_Function = Callable[[np.ndarray], np.ndarray]


class RunningCost(Protocol):
    """A running cost ``l(t, q, v, a, u)`` with ``u = rnea(q, v, a)``: any object with these methods.

    Threads call them, one at a time.
    """

    def value(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray, u: np.ndarray) -> float:
        """``l``."""

    def derivatives(
        self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray, u: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Its gradient, (4 N,), and Hessian, (4 N, 4 N), in ``[q; v; a; u]``, with ``u`` as an independent variable."""


class Constraint(Protocol):
    """A constraint ``g(q, v) <= 0``: any object with these members.

    ``scales``, shape (rows,), the growth of each row with its bounded quantity, and ``names`` of the rows are optional.
    """

    rows: int

    def value(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """``g``, shape (rows,)."""

    def derivatives(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Its Jacobian, shape (rows, 2 N), and the Hessians of its rows, shape (rows, 2 N, 2 N), in ``[q; v]``."""


def check(model: Model, *, samples: int = 100, seed: int = 0) -> Table:
    """Compares every analytic derivative with dual numbers at random states of a robot.

    Returns
    -------
    Table
        One row per quantity: ``quantity``, ``k`` (the penalty, if the quantity depends on it), ``error`` (the largest,
        relative), ``bound``, ``passes``, and the ``entry`` and the number of the ``sample`` with this error.
    """
    findings = json.loads(_aghf.check(model._own, samples, seed))
    columns = ("quantity", "k", "error", "bound")
    return Table.from_rows(
        {
            **{name: finding[name] for name in columns},
            "passes": finding["error"] is not None and finding["error"] <= finding["bound"],
            "entry": tuple(finding["entry"]),
            "sample": finding["sample"],
        }
        for finding in findings
    )


def check_cost(model: Model, cost: RunningCost, *, samples: int = 10, seed: int = 0) -> Table:
    """Compares the derivatives of a running cost in Python with its values.

    Values and gradients are differentiated by complex steps, exact up to rounding, if the functions accept complex
    arrays, otherwise by central differences.

    Returns
    -------
    Table
        One row per quantity: ``quantity``, ``witness``, ``error`` (the largest, relative), ``bound`` and ``passes``.
    """

    def states(random: np.random.Generator) -> np.ndarray:
        q, v, a = random.normal(size=(3, model.dof))
        return np.concatenate([q, v, a, rnea(model, q, v, a)])

    def parts(y: np.ndarray) -> Any:
        return (0.3, *np.split(y, 4))

    return _compare(
        states,
        lambda y: np.atleast_1d(cost.value(*parts(y))),
        lambda y: np.asarray(cost.derivatives(*parts(y))[0])[None],
        lambda y: np.asarray(cost.derivatives(*parts(y))[1])[None],
        ("gradient", "Hessian"),
        samples,
        seed,
    )


def check_constraint(model: Model, constraint: Constraint, *, samples: int = 10, seed: int = 0) -> Table:
    """Compares the derivatives of a constraint in Python with its values, as `check_cost` does."""
    return _compare(
        lambda random: random.normal(size=2 * model.dof),
        lambda x: constraint.value(*np.split(x, 2)),
        lambda x: constraint.derivatives(*np.split(x, 2))[0],
        lambda x: constraint.derivatives(*np.split(x, 2))[1],
        ("Jacobian", "Hessians"),
        samples,
        seed,
    )


def _compare(
    states: Callable[[np.random.Generator], np.ndarray],
    value: _Function,
    first: _Function,
    second: _Function,
    names: tuple[str, str],
    samples: int,
    seed: int,
) -> Table:
    random = np.random.default_rng(seed)
    worst: dict[tuple[str, str], float] = {}
    for _ in range(samples):
        x = states(random)
        for name, of, derivative in zip(names, (value, first), (first, second), strict=True):
            expected, witness = _derivative(of, x)
            ours = np.asarray(derivative(x), dtype=float)
            if ours.shape != expected.shape:
                raise ValueError(f"{name}: its shape is {ours.shape[-2:]}, expected {expected.shape[-2:]}")
            error = np.abs(ours - expected).max() / max(np.abs(expected).max(), 1.0)
            largest = worst.get((name, witness), 0.0)
            worst[name, witness] = max(largest, error, key=lambda e: np.inf if np.isnan(e) else e)
    return Table.from_rows(
        {
            "quantity": name,
            "witness": witness,
            "error": error,
            "bound": _BOUND[witness],
            "passes": bool(error <= _BOUND[witness]),
        }
        for (name, witness), error in worst.items()
    )


def _derivative(of: _Function, x: np.ndarray) -> tuple[np.ndarray, str]:
    """The derivative of a function, with the index of ``x`` last, and its method."""
    try:
        with warnings.catch_warnings():
            # Raised by functions that write complex numbers into real arrays.
            warnings.simplefilter("error", np.exceptions.ComplexWarning)
            return _by_columns(lambda e: np.imag(of(x + 1j * _COMPLEX * e)) / _COMPLEX, x, of), "complex step"
    except (TypeError, ValueError, np.exceptions.ComplexWarning, _NotComplex):
        difference = _by_columns(lambda e: (of(x + _STEP * e) - of(x - _STEP * e)) / (2 * _STEP), x)
        return difference, "central difference"


class _NotComplex(Exception):
    """A function lost the imaginary part of its argument."""


def _by_columns(column: _Function, x: np.ndarray, of: _Function | None = None) -> np.ndarray:
    if of is not None and not np.iscomplexobj(of(x + 0j)):
        raise _NotComplex
    return np.stack([np.asarray(column(e), dtype=float) for e in np.eye(x.size)], axis=-1)
