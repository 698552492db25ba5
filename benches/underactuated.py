#!/usr/bin/env python3
"""Finds the least effort of scenarios with passive joints by IPOPT, from many starts: a reference for `aghf solve`.

    python -m venv VENV && VENV/bin/pip install pin==4.1.0 casadi==3.8.2 numpy
    VENV/bin/python benches/underactuated.py                     # all, into robots/underactuated_ipopt.json
    VENV/bin/python benches/underactuated.py acrobot_swingup --starts 50 --intervals 40

The motion is collocated at the three Gauss points of each interval. The unknowns are the state at the beginning of the
interval and the accelerations at these points; position and velocity at the points are their Runge-Kutta integrals, of
order six over an interval. Equalities require zero torques of the passive joints at the points; the objective is the
Gauss quadrature of the squares of the other torques, with exact Hessians from CasADi. Pinocchio reads the URDF, and the
inverse dynamics, a CasADi expression in this file, are compared with Pinocchio's. Starts are the cubic between the ends
and the same with random bends, each solved again from its solution on twice the intervals. The result is the best
effort that changes by at most 1e-3 with four times the intervals. Limits are ignored.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin

ROBOTS = Path(__file__).resolve().parents[1] / "robots"
TABLE = ROBOTS / "underactuated_ipopt.json"
# Gauss points on [0, 1] with their Runge-Kutta matrix and weights.
NODES = (np.polynomial.legendre.leggauss(3)[0] + 1) / 2
POWERS = np.vander(NODES, increasing=True)
MATRIX = np.array([[c ** (j + 1) / (j + 1) for j in range(3)] for c in NODES]) @ np.linalg.inv(POWERS)
WEIGHTS = np.array([1 / (j + 1) for j in range(3)]) @ np.linalg.inv(POWERS)
# The largest relative difference of efforts that count as one minimum.
SAME = 1e-3


def cross(w):
    """The matrix of the product with `w` from the left."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def inverse_dynamics(urdf):
    """The torques of a tree of joints of one degree as a CasADi function of positions, velocities and accelerations."""
    model = pin.buildModelFromUrdf(str(urdf))
    data, n = model.createData(), model.nv
    pin.computeJointJacobians(model, data, pin.neutral(model))
    q, v, a = (ca.SX.sym(name, n) for name in "qva")
    axes, places, bodies, torques = [], [], [], [None] * n
    for i in range(n):
        # The motion subspace of the joint in the axes of its body: a direction of translation or rotation.
        allowed = pin.getJointJacobian(model, data, i + 1, pin.LOCAL)[:, model.joints[i + 1].idx_v].round(12)
        slide, turn = allowed[:3], allowed[3:]
        axes.append((slide, turn))
        placement = model.jointPlacements[i + 1]
        k = cross(turn)
        rotation = ca.SX(placement.rotation) @ (ca.SX.eye(3) + ca.sin(q[i]) * k + (1 - ca.cos(q[i])) * (k @ k))
        shift = ca.SX(placement.translation) + ca.SX(placement.rotation @ slide) * q[i]
        places.append((rotation, shift))
        parent = model.parents[i + 1] - 1
        # Angular velocity, angular and linear acceleration of the body before it; gravity is an acceleration of the
        # base.
        base = (ca.SX.zeros(3), ca.SX.zeros(3), ca.SX(-model.gravity.linear))
        w, dw, dv = bodies[parent][:3] if parent >= 0 else base
        moved = dv + ca.cross(dw, shift) + ca.cross(w, ca.cross(w, shift))
        w, dw, dv = rotation.T @ w, rotation.T @ dw, rotation.T @ moved
        dw, dv = dw + turn * a[i] + ca.cross(w, turn * v[i]), dv + slide * a[i] + 2 * ca.cross(w, slide * v[i])
        w = w + turn * v[i]
        inertia = model.inertias[i + 1]
        lever = ca.SX(inertia.lever)
        force = inertia.mass * (dv + ca.cross(dw, lever) + ca.cross(w, ca.cross(w, lever)))
        moment = inertia.inertia @ dw + ca.cross(w, inertia.inertia @ w) + ca.cross(lever, force)
        bodies.append([w, dw, dv, force, moment])
    for i in reversed(range(n)):
        (slide, turn), (rotation, shift) = axes[i], places[i]
        force, moment = bodies[i][3:]
        torques[i] = ca.dot(slide, force) + ca.dot(turn, moment)
        parent = model.parents[i + 1] - 1
        if parent >= 0:
            force = rotation @ force
            bodies[parent][3] += force
            bodies[parent][4] += rotation @ moment + ca.cross(shift, force)
    function = ca.Function("inverse_dynamics", [q, v, a], [ca.vertcat(*torques)])
    x = np.random.default_rng(0).normal(size=(3, n))
    theirs = pin.rnea(model, data, pin.integrate(model, pin.neutral(model), x[0]), x[1], x[2])
    assert np.abs(np.array(function(*x)).ravel() - theirs).max() < 1e-9, "not the dynamics of Pinocchio"
    return function, [model.names[i + 1] for i in range(n)]


class Collocation:
    """A scenario on equal intervals as a nonlinear program."""

    def __init__(self, scenario, dynamics, passive, intervals):
        self.scenario, self.intervals, n = scenario, intervals, len(scenario["q_start"])
        self.n, self.h = n, scenario["horizon_s"] / intervals
        driven = [i for i in range(n) if i not in passive]
        h = self.h
        # One interval: from its unknowns to the state at its end, its effort, and the torques that must vanish.
        q, v, a = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("a", n, 3)
        vs = ca.repmat(v, 1, 3) + h * (a @ MATRIX.T)
        qs = ca.repmat(q, 1, 3) + h * (vs @ MATRIX.T)
        torques = ca.horzcat(*(dynamics(qs[:, j], vs[:, j], a[:, j]) for j in range(3)))
        effort = h * ca.dot(ca.sum1(torques[driven, :] ** 2).T, WEIGHTS)
        end = [q + h * (vs @ WEIGHTS), v + h * (a @ WEIGHTS)]
        values = [ca.vertcat(*end), effort, ca.vec(torques[passive, :])]
        of = ca.Function("interval", [ca.vertcat(q, v, ca.vec(a))], values)
        x = ca.MX.sym("x", 5 * n, intervals)
        ends, efforts, zeros = of.map(intervals)(x)
        start = ca.DM(scenario["q_start"] + scenario["v_start"])
        goal = ca.DM(scenario["q_goal"] + scenario["v_goal"])
        states = ca.horzcat(x[: 2 * n, :], goal)
        rows = ca.vertcat(x[: 2 * n, 0] - start, ca.vec(ends - states[:, 1:]), ca.vec(zeros))
        programme = {"x": ca.vec(x), "f": ca.sum2(efforts), "g": rows}
        silent = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes"}
        options = {**silent, "ipopt.max_iter": 1500, "ipopt.tol": 1e-8}
        self.solver = ca.nlpsol("solver", "ipopt", programme, options)

    def guess(self, seed, amplitude):
        """The cubic between the ends, bent unless `seed` is zero."""
        scenario, horizon = self.scenario, self.scenario["horizon_s"]
        s = (np.arange(self.intervals)[:, None] + np.append(0, NODES)) / self.intervals
        q0, v0, q1, v1 = (np.array(scenario[key])[:, None, None] for key in ("q_start", "v_start", "q_goal", "v_goal"))
        q = q0 + (q1 - q0) * (3 * s**2 - 2 * s**3)
        q = q + (v0 * horizon) * (s - 2 * s**2 + s**3) + (v1 * horizon) * (s**3 - s**2)
        if seed:
            random = np.random.default_rng(seed)
            window = (4 * s * (1 - s)) ** 2
            size = amplitude * random.uniform(0.2, 1.5)
            for k in range(4):
                amplitudes = size * random.normal(size=(self.n, 1, 1))
                q = q + amplitudes * window * np.sin((k + 1) * np.pi * s + random.uniform(0, np.pi))
        # Slopes by differences: a guess need not be exact.
        time_of = s.ravel() * horizon
        flat = q.reshape(self.n, -1)
        v = np.gradient(flat, time_of, axis=1)
        a = np.gradient(v, time_of, axis=1).reshape(q.shape)
        return self.pack(flat.reshape(q.shape)[:, :, 0], v.reshape(q.shape)[:, :, 0], a[:, :, 1:])

    @staticmethod
    def pack(q, v, a):
        """Positions and velocities `n x intervals` and accelerations `n x intervals x 3` as the unknowns."""
        return np.vstack([q, v, a.transpose(2, 0, 1).reshape(-1, q.shape[1])]).ravel(order="F")

    def halved(self, x):
        """The unknowns of the same motion on intervals of half the length."""
        n, x = self.n, np.array(x).reshape(-1, self.intervals, order="F")
        q, v = x[:n], x[n : 2 * n]
        a = x[2 * n :].reshape(3, n, -1).transpose(1, 2, 0)
        # The acceleration is the parabola through its values at the points.
        coefficients = a @ np.linalg.inv(POWERS).T
        at = lambda s: coefficients @ np.vander(np.atleast_1d(s), 3, increasing=True).T
        once = sum(coefficients[:, :, j] * 0.5 ** (j + 1) / (j + 1) for j in range(3))
        twice = sum(coefficients[:, :, j] * 0.5 ** (j + 2) / ((j + 1) * (j + 2)) for j in range(3))
        middle_q, middle_v = q + 0.5 * self.h * v + self.h**2 * twice, v + self.h * once
        weave = lambda first, second: np.stack([first, second], axis=2).reshape(n, 2 * self.intervals, *first.shape[2:])
        a = np.stack([at(NODES / 2), at((1 + NODES) / 2)], axis=2).reshape(n, 2 * self.intervals, 3)
        return self.pack(weave(q, middle_q), weave(v, middle_v), a)

    def solve(self, guess):
        """IPOPT's status, the effort and the unknowns."""
        found = self.solver(x0=guess, lbg=0, ubg=0)
        stats = self.solver.stats()
        outcome = {"status": stats["return_status"], "success": bool(stats["success"]), "effort": float(found["f"])}
        return outcome, found["x"]


def reference(name, starts, intervals, amplitude):
    """The entry of a scenario in the table."""
    path = next(ROBOTS.glob(f"*/{name}.json"))
    scenario = json.loads(path.read_text())
    dynamics, joints = inverse_dynamics(ROBOTS / scenario["robot"] / f"{scenario['robot']}.urdf")
    passive = [joints.index(joint) for joint in scenario["passive"]]
    began, solved = time.time(), []
    meshes = [Collocation(scenario, dynamics, passive, intervals * 2**k) for k in range(3)]
    for seed in range(starts):
        result, x = meshes[0].solve(meshes[0].guess(seed, amplitude))
        if result["success"]:
            # On a coarse mesh a motion may exploit the gaps between the points; only minima on a finer one count.
            result, x = meshes[1].solve(meshes[0].halved(x))
        if result["success"]:
            solved.append((result["effort"], seed, x))
    solved.sort(key=lambda found: found[0])
    efforts = [effort for effort, *_ in solved]
    for effort, seed, x in solved:
        finest, _ = meshes[2].solve(meshes[1].halved(x))
        if finest["success"] and abs(finest["effort"] - effort) < SAME * effort:
            break
    else:
        return {"status": "no start converged", "starts": starts, "converged_starts": len(solved)}
    short = lambda x: float(f"{x:.6g}")
    return {
        "effort": short(finest["effort"]),
        "effort_of_half_the_intervals": short(effort),
        "intervals": meshes[2].intervals,
        "status": finest["status"],
        "seed": seed,
        "starts": starts,
        "converged_starts": len(efforts),
        "starts_at_the_effort": sum(abs(other - effort) < SAME * effort for other in efforts),
        "quartiles_of_starts": [short(efforts[round(share * (len(efforts) - 1))]) for share in (0, 0.25, 0.5, 0.75, 1)],
        "seconds": round(time.time() - began),
    }


def main():
    known = [path.stem for path in sorted(ROBOTS.glob("*/*.json")) if "passive" in json.loads(path.read_text())]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=known, help="built-in scenarios with passive joints")
    parser.add_argument("--starts", type=int, default=50, help="the cubic, and bent ones")
    parser.add_argument("--intervals", type=int, default=40, help="of the first mesh of three")
    parser.add_argument("--amplitude", type=float, default=1.5, help="of the bends, rad or m")
    parser.add_argument("--out", type=Path, default=TABLE, help="the table, in which other scenarios stay as they are")
    options = parser.parse_args()
    for name in options.scenarios:
        entry = reference(name, options.starts, options.intervals, options.amplitude)
        settings = f"--starts {options.starts} --intervals {options.intervals} --amplitude {options.amplitude:g}"
        entry["command"] = f"benches/underactuated.py {name} {settings}"
        print(name, json.dumps(entry), flush=True)
        table = json.loads(options.out.read_text()) if options.out.exists() else {}
        table[name] = entry
        options.out.write_text(json.dumps(table, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
