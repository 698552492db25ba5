"""Inverse dynamics and joint frames of a tree of joints of one degree, as CasADi expressions."""

import casadi as ca
import numpy as np
import pinocchio as pin


def skew(w):
    """The matrix of the product with `w` from the left."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


class Expressions:
    """A Pinocchio model whose every joint turns about or slides along one axis."""

    def __init__(self, model):
        self.model, self.n, data = model, model.nv, model.createData()
        pin.computeJointJacobians(model, data, np.zeros(model.nq))
        local = [
            pin.getJointJacobian(model, data, i + 1, pin.LOCAL).reshape(6, -1)[:, i].round(12) for i in range(self.n)
        ]
        self.slides, self.turns = [s[:3] for s in local], [s[3:] for s in local]
        x = np.random.default_rng(0).normal(size=(3, self.n))
        symbols = [ca.SX.sym(name, self.n) for name in "qva"]
        mine = ca.Function("rnea", symbols, [self.rnea(*symbols)])
        off = np.abs(np.array(mine(*x)).ravel() - pin.rnea(model, data, *x)).max()
        assert off < 1e-8, f"{model.name}: not the inverse dynamics of Pinocchio, {off:.1e}"

    def placements(self, q):
        """Rotation and origin of each body in its parent."""
        result = []
        for i in range(self.n):
            turn, place = skew(self.turns[i]), self.model.jointPlacements[i + 1]
            rotation = ca.SX.eye(3) + ca.sin(q[i]) * turn + (1 - ca.cos(q[i])) * (turn @ turn)
            result.append((place.rotation @ rotation, place.translation + (place.rotation @ self.slides[i]) * q[i]))
        return result

    def frames(self, q):
        """Rotation and origin of each body in the base frame."""
        result = []
        for i, (rotation, origin) in enumerate(self.placements(q)):
            parent = self.model.parents[i + 1] - 1
            if parent >= 0:
                above, place = result[parent]
                rotation, origin = above @ rotation, place + above @ origin
            result.append((rotation, ca.SX(origin)))
        return result

    def rnea(self, q, v, a):
        """Torques by the recursive Newton-Euler algorithm in body frames, each force about the origin of its body."""
        zero = ca.SX.zeros(3)
        places, bodies = self.placements(q), []
        for i, (rotation, origin) in enumerate(places):
            parent = self.model.parents[i + 1] - 1
            w, dw, dv = bodies[parent][:3] if parent >= 0 else (zero, zero, ca.SX(-self.model.gravity.linear))
            turn, slide = self.turns[i], self.slides[i]
            dv = rotation.T @ (dv + ca.cross(dw, origin) + ca.cross(w, ca.cross(w, origin)))
            w, dw = rotation.T @ w, rotation.T @ dw
            dv = dv + slide * a[i] + 2 * ca.cross(w, slide * v[i])
            dw = dw + turn * a[i] + ca.cross(w, turn * v[i])
            w = w + turn * v[i]
            inertia = self.model.inertias[i + 1]
            lever = ca.SX(inertia.lever)
            force = inertia.mass * (dv + ca.cross(dw, lever) + ca.cross(w, ca.cross(w, lever)))
            moment = inertia.inertia @ dw + ca.cross(w, inertia.inertia @ w) + ca.cross(lever, force)
            bodies.append([w, dw, dv, force, moment])
        torques = [None] * self.n
        for i in reversed(range(self.n)):
            force, moment = bodies[i][3:]
            torques[i] = ca.dot(self.slides[i], force) + ca.dot(self.turns[i], moment)
            parent = self.model.parents[i + 1] - 1
            if parent >= 0:
                rotation, origin = places[i]
                force = rotation @ force
                bodies[parent][3] += force
                bodies[parent][4] += rotation @ moment + ca.cross(origin, force)
        return ca.vertcat(*torques)
