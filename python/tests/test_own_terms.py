"""Running costs and constraints written in Python."""

import numpy as np
import pytest

import aghf
from problems import SWING


class Squares:
    """``|u|^2 + weight |v|^2``, the sum of what a scenario can ask for."""

    def __init__(self, weight):
        self.weight = weight

    def value(self, t, q, v, a, u):
        return u @ u + self.weight * (v @ v)

    def derivatives(self, t, q, v, a, u):
        n = len(q)
        diagonal = np.concatenate([np.zeros(n), np.full(n, 2 * self.weight), np.zeros(n), np.full(n, 2.0)])
        return diagonal * np.concatenate([q, v, a, u]), np.diag(diagonal)


class Floor:
    """The end of the second pendulum, of 1 m like the first, does not sink below a height: a curved constraint."""

    rows = 1
    names = ("height of the end",)
    scales = np.array([2.0])

    def __init__(self, height):
        self.height = height

    def value(self, q, v):
        # Links are along -x at zero and turn about y.
        return 2 * np.array([self.height - np.sin(q[0]) - np.sin(q[0] + q[1])])

    def derivatives(self, q, v):
        both = q[0] + q[1]
        jacobian = -2 * np.array([[np.cos(q[0]) + np.cos(both), np.cos(both), 0, 0]])
        hessian = np.zeros((1, 4, 4), dtype=both.dtype)
        hessian[0, :2, :2] = 2 * np.sin(both)
        hessian[0, 0, 0] += 2 * np.sin(q[0])
        return jacobian, hessian


def test_a_cost_in_python_finds_what_the_same_cost_in_rust_does():
    model = aghf.Model.builtin("pendulum_2")
    table = aghf.check_cost(model, Squares(3.0))
    assert table["quantity"] == ["gradient", "Hessian"] and all(table["passes"])
    assert set(table["witness"]) == {"complex step"}
    ours = aghf.solve(SWING, starts=1, running_cost=Squares(3.0))
    theirs = aghf.solve({**SWING, "objective": {"units": "si", "velocity": 3.0}}, starts=1)
    assert ours.success and theirs.success
    assert ours.summary["cost"] == pytest.approx(theirs.summary["cost"], rel=1e-9)
    assert ours.summary["cost"] > aghf.solve(SWING, starts=1).summary["control_effort"]


def test_a_constraint_in_python_is_kept_and_judged():
    model, floor = aghf.Model.builtin("pendulum_2"), Floor(-0.005)
    table = aghf.check_constraint(model, floor)
    assert table["quantity"] == ["Jacobian", "Hessians"] and all(table["passes"])
    assert set(table["witness"]) == {"complex step"}

    def most(solution):
        return max(floor.value(q, None)[0] for q in solution.sample(2001).q)

    assert most(aghf.solve(SWING, starts=1)) > 0.01, "the free motion swings below it"
    kept = aghf.solve(SWING, starts=1, constraints=[floor])
    assert kept.success and most(kept) < 2e-6
    # It starts at zero.
    with pytest.raises(aghf.InputError, match="q_start: it violates height of the end by 1.000e-1"):
        aghf.solve(SWING, constraints=[Floor(0.1)])


def test_derivatives_that_are_wrong_are_found():
    model = aghf.Model.builtin("pendulum_2")

    class Wrong(Squares):
        def derivatives(self, t, q, v, a, u):
            gradient, hessian = super().derivatives(t, q, v, a, u)
            hessian[0, 1] += 1e-6
            gradient[3] *= 1 + 1e-7
            return gradient, hessian

    class Real(Squares):
        def value(self, t, q, v, a, u):
            return float(np.real(super().value(t, q, v, a, u)))

    assert aghf.check_cost(model, Wrong(1.0))["passes"] == [False, False]
    table = aghf.check_cost(model, Real(1.0))
    assert table["witness"] == ["central difference", "complex step"] and all(table["passes"])
    wrong = Floor(1.0)
    wrong.derivatives = lambda q, v: tuple(1.01 * part for part in Floor.derivatives(wrong, q, v))
    assert aghf.check_constraint(model, wrong)["passes"] == [False, True]


def test_what_a_function_raises_ends_the_solve():
    class Broken(Squares):
        def derivatives(self, t, q, v, a, u):
            raise RuntimeError("no derivatives today")

    class Shapeless(Squares):
        def derivatives(self, t, q, v, a, u):
            return np.zeros(3), np.zeros((3, 3))

    with pytest.raises(RuntimeError, match="no derivatives today"):
        aghf.solve(SWING, running_cost=Broken(1.0))
    with pytest.raises(ValueError, match="gradient: its shape is"):
        aghf.solve(SWING, running_cost=Shapeless(1.0))
    with pytest.raises(AttributeError, match="rows"):
        aghf.solve(SWING, constraints=[object()])
    with pytest.raises(AttributeError, match="value"):
        aghf.solve(SWING, running_cost=object())
    with pytest.raises(aghf.InputError, match="running cost"):
        aghf.solve(SWING, running_cost=Squares(1.0), method="flow")
