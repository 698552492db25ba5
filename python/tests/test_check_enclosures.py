"""The arithmetic of the checker of certificates: each operation encloses the value in 60 digits, and not by far."""

import random
from decimal import Decimal, getcontext

import numpy as np
import pytest

from aghf.check_certificate import Model, Motion, cut, least, sums

CASES = 200


@pytest.fixture(autouse=True)
def precision():
    getcontext().prec = 60


def value(c, s):
    """The value of a polynomial with coefficients in floating point, exactly."""
    total = Decimal(0)
    for x in reversed(c):
        total = total * s + Decimal(float(x))
    return total


def sine(x):
    term, total, k = x, x, 1
    while abs(term) > Decimal("1e-55"):
        term *= -x * x / ((k + 1) * (k + 2))
        total, k = total + term, k + 2
    return total


def drawn(rng, first, order):
    """A constant, a line, or a polynomial of which all coefficients count, and how far a function is from it."""
    count, most = rng.choice([(1, 0.0), (2, 0.6), (order, 0.3 / order)])
    c = np.array([rng.uniform(-most, most) if k < count else 0.0 for k in range(order)])
    c[0] = first
    return Model(c.reshape(order, 1), np.array([rng.choice([0.0, 1e-13, 1e-3])]))


@pytest.mark.parametrize("seed", range(3))
def test_operations_enclose_their_values(seed):
    rng = random.Random(seed)
    for _ in range(CASES):
        order = rng.choice([1, 4, 10, 24])
        a, b = drawn(rng, rng.uniform(0.7, 3.0), order), drawn(rng, rng.uniform(-3.0, 3.0), order)
        divisor = rng.uniform(0.1, 3.0)
        found = {
            "sum": (a + b, lambda x, y: x + y),
            "difference": (a - b, lambda x, y: x - y),
            "product": (a * b, lambda x, y: x * y),
            "quotient": (a.over(divisor), lambda x, y, by=divisor: x / Decimal(by)),
            "sine": (b.sin_cos()[0], lambda x, y: sine(y)),
            "cosine": (b.sin_cos()[1], lambda x, y: (1 - sine(y / 2) ** 2 * 2)),
            "root": (a.inverse_sqrt(), lambda x, y: 1 / x.sqrt()),
        }
        for s in (Decimal(-1), Decimal(1), Decimal(rng.uniform(-1.0, 1.0))):
            side = rng.choice([-1, 0, 1]), rng.choice([-1, 0, 1])
            x, y = (value(m.c[:, 0], s) + Decimal(float(m.r[0])) * k for m, k in zip((a, b), side))
            for name, (model, exact) in found.items():
                off, radius = abs(value(model.c[:, 0], s) - exact(x, y)), Decimal(float(model.r[0]))
                assert off <= radius, f"{name} of order {order}: off by {off:.3e}, at most {radius:.3e}"


def test_sums_of_products_enclose_their_values():
    rng = np.random.default_rng(3)
    for n in (1, 2, 8, 40):
        a, b = rng.uniform(-1.0, 1.0, (2, n)), rng.uniform(-1.0, 1.0, (n, 3))
        # Terms that cancel, of which nothing but the errors is left.
        a, b = np.hstack([a, -a]), np.vstack([b, b])
        off_a, off_b = (rng.choice([0.0, 1e-13], x.shape) for x in (a, b))
        found = sums(Model(a[np.newaxis], off_a), Model(b[np.newaxis], off_b))
        for signs in (0.0, 1.0, -1.0):
            x, y = ([list(map(Decimal, row)) for row in m.tolist()] for m in (a, b))
            more_x, more_y = ([list(map(Decimal, row)) for row in (m * signs).tolist()] for m in (off_a, off_b))
            for i, j in np.ndindex(2, 3):
                terms = ((x[i][k] + more_x[i][k]) * (y[k][j] + more_y[k][j]) for k in range(2 * n))
                assert abs(Decimal(float(found.c[0, i, j])) - sum(terms)) <= Decimal(float(found.r[i, j]))


def test_enclosures_are_narrow():
    a = Model.constant([1.5], order=24)
    a.c[1] = 0.3
    for model in (a * a, a.over(3.0), *a.sin_cos(), a + a):
        assert model.r[0] < 1e-13
    assert a.inverse_sqrt().r[0] < 1e-11


def chebyshev(c, x):
    """The value of a series of Chebyshev polynomials."""
    below, own, total = Decimal(1), x, c[0]
    for ck in c[1:]:
        total, below, own = total + ck * own, own, 2 * x * own - below
    return total


def rates(c):
    """The Chebyshev coefficients of the derivative, by the sum over all higher ones of the other parity."""
    n = len(c) - 1
    return [sum((2 - (k == 0)) * j * c[j] for j in range(k + 1, n + 1, 2)) for k in range(n)] or [Decimal(0)]


@pytest.mark.parametrize("degree", [1, 2, 3, 8, 16, 40])
def test_expansions_enclose_the_motion_and_its_rates(degree):
    rng = random.Random(degree)
    segments, horizon = 2, 3.0
    rows = [[rng.uniform(-1.0, 1.0) / (1 + k * k) for k in range(degree + 1)] for _ in range(segments)]
    velocities = [[float(x) * 2 * segments / horizon for x in rates(list(map(Decimal, c)))] + [0.0] for c in rows]
    coefficients = [[c, v] for c, v in zip(rows, velocities)]
    curve = {"horizon_s": horizon, "joints": ["j"], "degree": degree, "segments": segments}
    motion = Motion(curve | {"coefficients": coefficients})
    own, w = np.array([0, 1, 0, 1]), np.array([2.0**-3, 2.0**-20, 1.0, 0.375])
    m = np.array([0.25, -1.0, 0.0, 0.625])
    found = motion.expand(own, m, w)
    for i, segment in enumerate(own):
        c, rate = [Decimal(x) for x in rows[segment]], Decimal(2 * segments) / Decimal(horizon)
        for order, polynomials in enumerate(found):
            if order > 0:
                c = [x * rate for x in rates(c)]
            size = sum(map(abs, c), Decimal(1))
            for s in (Decimal(-1), Decimal(1), Decimal(rng.uniform(-1.0, 1.0))):
                exact = chebyshev(c, Decimal(float(m[i])) + Decimal(float(w[i])) * s)
                for part in (polynomials, cut(polynomials)):
                    off = abs(value(part.c[:, 0, i], s) - exact)
                    assert off <= Decimal(float(part.r[0, i])), f"order {order}, interval {i}: off by {off:.3e}"
            # Not by more than rounding, but for derivatives of high degrees on short intervals.
            assert degree > 8 or w[i] < 0.1 or polynomials.r[0, i] < 1e-12 * float(size)


def test_bounds_on_values_are_below_them():
    rng = np.random.default_rng(5)
    for order in (1, 2, 4, 10, 17):
        c, r = rng.uniform(-1.0, 1.0, (order, 50)), rng.choice([0.0, 1e-14, 0.1], 50)
        c[:, ::3] = np.round(c[:, ::3])
        found = least(Model(c, r), np.inf, 1e-9)
        s = np.linspace(-1.0, 1.0, 401)
        values = np.array([s**k for k in range(order)]).T @ c
        for i in range(50):
            at = Decimal(float(s[np.argmin(values[:, i])]))
            exact = value(c[:, i], at) - Decimal(float(r[i]))
            assert Decimal(float(found[i])) < exact, f"order {order}: {found[i]} is not below {exact}"
            assert found[i] > values[:, i].min() - r[i] - 1e-3
    with np.errstate(all="ignore"):
        for c, r in ((0.0, np.inf), (0.0, np.nan), (1e308, 0.0), (np.inf, 0.0), (np.nan, 0.0)):
            assert least(Model(np.full((3, 1), c), np.array([r])), 0.0, 1e-9)[0] == -np.inf
