"""Direct transcription: a motion as a nonlinear programme for IPOPT, all derivatives exact and in compiled C.

Two of them share the code. `Polynomial` is one polynomial for each joint in Legendre's basis, with points of Gauss and
Legendre;
`Shooting` has positions, velocities and accelerations at the ends of equal intervals as unknowns, within which
accelerations
are linear and what follows from them is exact, with equations that join the intervals and the rule of trapezoids.

At each point unknowns give `z = (q, v, a)` linearly. What is not linear, torques and distances, is a function of one
point, mapped
over all, so that the Hessian is made of small dense blocks.
"""

import hashlib
import os
import subprocess
import time

import casadi as ca
import numpy as np
from numpy.polynomial import legendre

from common import WORK

FLAGS = ["-O3", "-march=native", "-fPIC", "-shared"]
LARGE = ["-O1", "-march=native", "-fPIC", "-shared"]


def compiled(name, functions):
    """Compiles CasADi functions as C; the functions of the library by name and the seconds of `gcc`, zero if it was
    there."""
    folder = WORK / "generated"
    folder.mkdir(parents=True, exist_ok=True)
    generator = ca.CodeGenerator(f"{name}.c", {"with_header": False})
    for function in functions:
        generator.add(function)
    source = generator.dump()
    # Beyond this size the optimiser takes many minutes.
    flags = FLAGS if len(source) < 8_000_000 else LARGE
    key = hashlib.sha256((source + " ".join(flags)).encode()).hexdigest()[:16]
    library = folder / f"{name}_{key}.so"
    began, seconds = time.perf_counter(), 0.0
    if not library.exists():
        (folder / f"{name}.c").write_text(source)
        partial = library.with_suffix(".part")
        subprocess.run(["gcc", *flags, "-o", partial, folder / f"{name}.c", "-lm"], check=True)
        os.replace(partial, library)
        seconds = time.perf_counter() - began
    return {function.name(): ca.external(function.name(), str(library)) for function in functions}, seconds


class Transcription:
    """A robot's nonlinear programme, to be solved for any horizon, ends and obstacles of the same number.

    `limits` are those of `position`, `velocity` and `torque` that are kept, `spheres` how many obstacles there are,
    from which the joint frames keep clear, and `acceleration` is the weight of squared accelerations beside squared
    torques. As nothing is asked between the points, `margin` is the share of the limits of velocity and torque, and
    `clear` the distance from the spheres in m, that is left.
    """

    # Settings of IPOPT beside the common ones.
    settings = {}

    def __init__(self, expressions, limits=(), spheres=0, acceleration=0.0, iterations=1000, margin=0.01, clear=0.01):
        self.expressions, self.n, self.limits, self.spheres = expressions, expressions.n, tuple(limits), spheres
        self.acceleration, self.iterations, self.margin, self.clear = acceleration, iterations, margin, clear
        self.lay_out()
        self.build()

    def point_functions(self):
        """Cost, torques and squared distances at a point with their first and second derivatives."""
        n = self.n
        s, horizon = ca.SX.sym("s", 3 * n), ca.SX.sym("horizon")
        centres = ca.SX.sym("centres", 3, self.spheres)
        # `s` is in the unit of time of the transcription: derivatives by time have powers of `rate`.
        rate = self.rate(horizon)
        q, v, a = s[:n], s[n : 2 * n] * rate, s[2 * n :] * rate**2
        u = self.expressions.rnea(q, v, a)
        origins = [origin for _, origin in self.expressions.frames(q)]
        gaps = [ca.sumsqr(origin - centres[:, k]) for k in range(self.spheres) for origin in origins]
        gaps = ca.vertcat(*gaps) if gaps else ca.SX.zeros(0, 1)
        cost = ca.sumsqr(u) + self.acceleration * ca.sumsqr(a)
        inputs = [s, horizon] + [centres] * bool(self.spheres)
        rows = ([u] if "torque" in self.limits else []) + [gaps] * bool(self.spheres)
        values = ca.Function("values", inputs, [cost, *rows])
        first = ca.Function("first", inputs, [ca.densify(ca.gradient(cost, s)), *(ca.jacobian(row, s) for row in rows)])
        multipliers = [ca.SX.sym("l", row.shape[0]) for row in rows]
        weight = ca.SX.sym("w")
        lagrangian = weight * cost + sum(ca.dot(l, row) for l, row in zip(multipliers, rows))
        second = ca.Function("second", [*inputs, weight, *multipliers], [ca.hessian(lagrangian, s)[0]])
        return values, first, second

    def build(self):
        """The programme with its derivatives; the functions of a point are compiled."""
        n, m = self.n, self.points
        values, first, second = self.point_functions()
        name = f"points_{self.expressions.model.name}_{len(self.limits)}_{self.spheres}"
        library, self.compile_seconds = compiled(name, [values, first, second])
        values, first, second = (library[function.name()] for function in (values, first, second))
        x = ca.MX.sym("x", self.unknowns)
        p = ca.MX.sym("p", 1 + 3 * self.spheres)
        horizon, centres = p[0], ca.reshape(p[1:], 3, self.spheres)
        s = ca.reshape(self.at_points @ x, 3 * n, m)
        inputs = [s, ca.repmat(horizon, 1, m)] + [ca.repmat(centres, 1, m)] * bool(self.spheres)
        weights = ca.DM(self.weights).T * self.unit(horizon)
        rate = self.rate(horizon)
        linear, jacobian = [self.joined @ x], [ca.MX(self.joined)]
        self.rows = ["joined"]
        for name, order in (("position", 0), ("velocity", 1)):
            if name in self.limits:
                self.rows.append(name)
                chosen = self.at_points[self.chosen(name, order), :]
                linear.append(rate**order * (chosen @ x))
                jacobian.append(rate**order * ca.MX(chosen))
        mapped = values.map(m)(*inputs)
        mapped = mapped if isinstance(mapped, (tuple, list)) else [mapped]
        self.rows += ["torque"] * ("torque" in self.limits) + ["gaps"] * bool(self.spheres)
        f, g = ca.dot(weights, mapped[0]), ca.vertcat(*linear, *map(ca.vec, mapped[1:]))
        slopes = first.map(m)(*inputs)
        slopes = slopes if isinstance(slopes, (tuple, list)) else [slopes]
        gradient = self.at_points.T @ ca.vec(slopes[0] * ca.repmat(weights, 3 * n, 1))
        blocks = lambda stacked, width: ca.diagcat(*ca.horzsplit(stacked, width))
        jacobian += [blocks(rows, 3 * n) @ self.at_points for rows in slopes[1:]]
        sigma, multipliers = ca.MX.sym("sigma"), ca.MX.sym("multipliers", g.shape[0])
        ends = np.cumsum([0, sum(part.shape[0] for part in linear), *(part.numel() for part in mapped[1:])])
        of_rows = [ca.reshape(multipliers[a:b], part.shape) for a, b, part in zip(ends[1:], ends[2:], mapped[1:])]
        curvature = blocks(second.map(m)(*inputs, sigma * weights, *of_rows), 3 * n)
        # Only the upper triangle is computed.
        half = curvature @ self.at_points
        pattern = (ca.DM(self.at_points.sparsity(), 1).T @ ca.DM(half.sparsity(), 1)).sparsity()
        upper = ca.triu(ca.DM(pattern, 1)).sparsity()
        hessian = ca.mac(ca.MX(self.at_points.T), half, ca.MX(upper, 0.0))
        programme = {"x": x, "p": p, "f": f, "g": g}
        options = {
            "grad_f": ca.Function("nlp_grad_f", [x, p], [f, ca.densify(gradient)]),
            "jac_g": ca.Function("nlp_jac_g", [x, p], [g, ca.vertcat(*jacobian)]),
            "hess_lag": ca.Function("nlp_hess_l", [x, p, sigma, multipliers], [hessian]),
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "print_time": 0,
            "no_nlp_grad": True,
            "calc_lam_p": False,
            "ipopt.max_iter": self.iterations,
            "ipopt.tol": 1e-6,
            **self.settings,
        }
        self.solver = ca.nlpsol("solver", "ipopt", programme, options)

    def chosen(self, name, order):
        """The rows of `at_points` that have a limit: not those of joints without one."""
        low, high = self.bounds_of(name)
        limited = [j for j in range(self.n) if np.isfinite(low[j]) or np.isfinite(high[j])]
        return [i * 3 * self.n + order * self.n + j for i in range(self.points) for j in limited]

    def bounds_of(self, name):
        """Lower and upper limits of each joint, infinite where there is none."""
        model = self.expressions.model
        if name == "position":
            low, high = model.lowerPositionLimit, model.upperPositionLimit
        else:
            high = (1 - self.margin) * (model.velocityLimit if name == "velocity" else model.effortLimit)
            low = -high
        far = lambda x: np.where(abs(x) > 1e8, np.copysign(np.inf, x), x)
        return far(low), far(high)

    def solve(self, scenario):
        """Solves a scenario from the cubic between its ends: IPOPT's statistics, seconds and the unknowns."""
        spheres = [obstacle for obstacle in scenario.get("obstacles", []) if "sphere" in obstacle["shape"]]
        low, high = [], []
        for name in self.rows:
            if name == "joined":
                value = self.joined_values(scenario)
                low.append(value), high.append(value)
            elif name == "gaps":
                radii = [o["shape"]["sphere"]["radius_m"] + self.clear for o in spheres]
                radii = np.repeat(radii, self.n) ** 2
                low.append(np.tile(radii, self.points)), high.append(np.full(radii.size * self.points, np.inf))
            else:
                some = [np.isfinite(a) or np.isfinite(b) or name == "torque" for a, b in zip(*self.bounds_of(name))]
                lower, upper = (bound[some] for bound in self.bounds_of(name))
                low.append(np.tile(lower, self.points)), high.append(np.tile(upper, self.points))
        centres = [c for sphere in spheres[: self.spheres] for c in sphere["pose"]["position_m"]]
        parameters = [scenario["horizon_s"], *centres]
        guess = self.guess(scenario)
        began = time.perf_counter()
        found = self.solver(x0=guess, p=parameters, lbg=np.concatenate(low), ubg=np.concatenate(high))
        seconds = time.perf_counter() - began
        return self.solver.stats(), seconds, np.array(found["x"]).ravel()


def cubic(scenario, times, order):
    """The cubic between the ends of a scenario, or its derivative by time, `n` x times."""
    horizon = scenario["horizon_s"]
    q0, v0, q1, v1 = (np.array(scenario[key])[:, None] for key in ("q_start", "v_start", "q_goal", "v_goal"))
    bends = (q0, horizon * v0, 3 * (q1 - q0) - horizon * (2 * v0 + v1), 2 * (q0 - q1) + horizon * (v0 + v1))
    s = np.asarray(times) / horizon
    powers = np.polynomial.polynomial.Polynomial
    basis = [powers(np.eye(4)[k]).deriv(order)(s) if order else s**k for k in range(4)]
    return sum(bend * values for bend, values in zip(bends, basis)) / horizon**order


class Polynomial(Transcription):
    """One polynomial for each joint, by its coefficients in Legendre's basis on [-1, 1]."""

    def __init__(self, expressions, degree=16, points=60, **options):
        self.degree, self.points = degree, points
        super().__init__(expressions, **options)

    def rate(self, horizon):
        return 2 / horizon

    def unit(self, horizon):
        return horizon / 2

    def table(self, s, order):
        """The values of the basis, or of its derivatives, at `s`: a row for each."""
        basis = [legendre.Legendre.basis(k) for k in range(self.degree + 1)]
        return np.array([(b.deriv(order) if order else b)(np.asarray(s)) for b in basis]).T

    def lay_out(self):
        """Unknowns, points with their weights, and what maps the former to `z` at the latter."""
        self.unknowns = self.n * (self.degree + 1)
        nodes, self.weights = legendre.leggauss(self.points)
        tables = np.stack([self.table(nodes, order) for order in range(3)], axis=1).reshape(-1, self.degree + 1)
        self.at_points = ca.kron(ca.sparsify(ca.DM(tables)), ca.DM.eye(self.n))
        ends = np.vstack([self.table([-1, 1], order) for order in range(2)])
        self.joined = ca.sparsify(ca.DM(np.kron(ends, np.eye(self.n))))

    def joined_values(self, scenario):
        rate = self.rate(scenario["horizon_s"])
        slopes = [np.array(scenario[key]) / rate for key in ("v_start", "v_goal")]
        return np.concatenate([scenario["q_start"], scenario["q_goal"], *slopes])

    def guess(self, scenario):
        s = np.cos(np.pi * np.arange(2 * self.degree + 1) / (2 * self.degree))
        path = cubic(scenario, (s + 1) * scenario["horizon_s"] / 2, 0)
        return np.linalg.lstsq(self.table(s, 0), path.T, rcond=None)[0].ravel()

    def sampled(self, scenario, x, times):
        """Positions, velocities and accelerations, a row for each time."""
        horizon = scenario["horizon_s"]
        c = x.reshape(self.degree + 1, self.n)
        return [(self.table(2 * times / horizon - 1, order) @ c) * self.rate(horizon) ** order for order in range(3)]


class Shooting(Transcription):
    """Equal intervals with linear accelerations, joined by equations, with three points of Gauss in each."""

    # Seven times as fast among spheres as with MUMPS' own scaling, and no slower elsewhere.
    settings = {"ipopt.mumps_permuting_scaling": 0, "ipopt.mumps_scaling": 0}

    def __init__(self, expressions, intervals=40, **options):
        self.intervals, self.points = intervals, 3 * intervals
        super().__init__(expressions, **options)

    def rate(self, horizon):
        return 2 / horizon

    def unit(self, horizon):
        return horizon / 2

    def lay_out(self):
        """Unknowns are `q`, `v`, `a` at the ends of the intervals, with half of the horizon as the unit of time, node
        by node."""
        self.unknowns = 3 * self.n * (self.intervals + 1)
        h = 2 / self.intervals
        nodes, weights = legendre.leggauss(3)
        self.weights = np.tile(h * weights / 2, self.intervals)
        # Within an interval: z at `s` from z at its beginning and from z at its end, of which the acceleration counts.
        at = h * (nodes + 1) / 2
        begins = [np.array([[1, s, s**2 / 2 - s**3 / 6 / h], [0, 1, s - s**2 / 2 / h], [0, 0, 1 - s / h]]) for s in at]
        ends = [np.array([[0, 0, s**3 / 6 / h], [0, 0, s**2 / 2 / h], [0, 0, s / h]]) for s in at]
        before, after = np.eye(self.intervals + 1)[:-1], np.eye(self.intervals + 1)[1:]
        maps = np.kron(before, np.vstack(begins)) + np.kron(after, np.vstack(ends))
        steps = np.kron(before, [[1, h, h**2 / 3], [0, 1, h / 2]]) + np.kron(after, [[-1, 0, h**2 / 6], [0, -1, h / 2]])
        first, last = np.eye(self.unknowns // self.n)[[0, 1]], np.eye(self.unknowns // self.n)[[-3, -2]]
        large = lambda matrix: ca.kron(ca.sparsify(ca.DM(matrix)), ca.DM.eye(self.n))
        self.at_points, self.joined = large(maps), large(np.vstack([steps, first, last]))

    def joined_values(self, scenario):
        rate = self.rate(scenario["horizon_s"])
        ends = [scenario["q_start"], np.divide(scenario["v_start"], rate)]
        ends += [scenario["q_goal"], np.divide(scenario["v_goal"], rate)]
        return np.concatenate([np.zeros(2 * self.n * self.intervals), *ends])

    def guess(self, scenario):
        times = np.linspace(0, scenario["horizon_s"], self.intervals + 1)
        rate = self.rate(scenario["horizon_s"])
        return np.vstack([cubic(scenario, times, order) / rate**order for order in range(3)]).T.ravel()

    def sampled(self, scenario, x, times):
        """Positions, velocities and accelerations, a row for each time."""
        rate = self.rate(scenario["horizon_s"])
        z = x.reshape(self.intervals + 1, 3, self.n)
        h = 2 / self.intervals
        i = np.minimum((times * rate / h).astype(int), self.intervals - 1)
        s = (times * rate - i * h)[:, None]
        q, v, a = (z[i, k] for k in range(3))
        jerk = (z[i + 1, 2] - a) / h
        q, v, a = q + s * v + s**2 / 2 * a + s**3 / 6 * jerk, v + s * a + s**2 / 2 * jerk, a + s * jerk
        return [q, rate * v, rate**2 * a]
