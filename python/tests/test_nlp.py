"""Smooth programs from Python."""

import math

import numpy as np
import pytest

import aghf


class Hs71:
    """Problem 71 of Hock and Schittkowski."""

    def objective(self, x):
        return x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2]

    def gradient(self, x):
        a, b, c, d = x
        return np.array([d * (2 * a + b + c), a * d, a * d + 1, a * (a + b + c)])

    def constraints(self, x):
        return np.array([x.prod(), x @ x])

    def jacobian(self, x):
        return np.array([x.prod() / x, 2 * x])

    def hessian(self, x, y):
        a, b, c, d = x
        of = np.array([[2 * d, d, d, 2 * a + b + c], [d, 0, 0, a], [d, 0, 0, a], [2 * a + b + c, a, a, 0]])
        product = x.prod() / np.outer(x, x)
        np.fill_diagonal(product, 0.0)
        return of + y[0] * product + 2 * y[1] * np.eye(4)


BOUNDS = [[1, 5]] * 4
ROWS = [[25, math.inf], [40, 40]]


def test_hs71():
    found = aghf.solve_nlp(Hs71(), [1, 5, 5, 1], BOUNDS, ROWS)
    assert found.status == "Converged"
    # The digits of Hock and Schittkowski.
    np.testing.assert_allclose(found.x, [1, 4.7429994, 3.8211503, 1.3794082], atol=1e-6)
    np.testing.assert_allclose(found.objective, 17.0140173, atol=1e-6)
    np.testing.assert_allclose(found.multipliers, [-0.5522937, 0.1614686], atol=1e-6)
    assert max(found.stationarity, found.feasibility, found.complementarity) <= 1e-8
    assert found.iterations < 30


class Parabola:
    """A program without rows, negative at its minimum."""

    def objective(self, x):
        return float((x - 1) @ (x - 1)) - 7

    def gradient(self, x):
        return 2 * (x - 1)

    def hessian(self, x, y):
        assert y.shape == (0,)
        return 2 * np.eye(len(x))


def test_without_rows():
    found = aghf.solve_nlp(Parabola(), [3, 4, 5], [[-math.inf, math.inf]] * 3)
    assert found.status == "Converged"
    np.testing.assert_allclose(found.x, 1, atol=1e-8)
    assert found.objective == pytest.approx(-7)


def test_an_exception_is_raised_again():
    class Broken(Parabola):
        def gradient(self, x):
            raise RuntimeError("no gradient today")

    with pytest.raises(RuntimeError, match="no gradient today"):
        aghf.solve_nlp(Broken(), [3], [[-1, 9]])


@pytest.mark.parametrize(
    ("x", "bounds", "part"),
    [([3], [[4, 1]], "unknown 0"), ([3, 4], [[0, 9]], "2 entries"), ([math.nan], [[0, 9]], "x")],
)
def test_bad_input(x, bounds, part):
    with pytest.raises(ValueError, match=part):
        aghf.solve_nlp(Parabola(), x, bounds)


def test_a_wrong_shape_is_named():
    class Wrong(Parabola):
        def gradient(self, x):
            return np.zeros(5)

    with pytest.raises(ValueError, match="gradient: its shape is"):
        aghf.solve_nlp(Wrong(), [3], [[0, 9]])
