"""The quantities of Pinocchio in the conventions of aghf: one position per joint, derivative indices last."""

import numpy as np
import pinocchio as pin


def placements(poses):
    """One row per pose: its rotation by rows, and its translation."""
    rows = [np.append(pose.rotation.ravel(), pose.translation) for pose in poses]
    return np.array(rows).reshape(-1, 12)


def derivative(f, x, i, turns, degree):
    """df / dx_i, without a truncation error.

    Along an angle (`turns`) `f` is a trigonometric polynomial of this degree d, and its values at 2 d + 1 equidistant
    angles give its derivative exactly: the weights are those of the derivative of the trigonometric interpolant
    (Trefethen, Spectral Methods in MATLAB, chapter 3, for an odd number of points). Along any other variable it is a
    polynomial of this degree, for which the central difference of order two (degrees 1, 2) or four (3, 4) is exact with
    any step; here 1.

    The rounding error is the sum of the absolute weights (2.8 and 4.4 for angles of degree 2 and 4; 1 and 1.5) times
    that of the largest value of `f`.
    """
    if turns:
        m = 2 * degree + 1
        offsets = 2 * np.pi / m * np.arange(1, degree + 1)
        weights = [(-1) ** (j + 1) / (2 * np.sin(j * np.pi / m)) for j in range(1, degree + 1)]
    else:
        offsets, weights = ([1], [1 / 2]) if degree <= 2 else ([1, 2], [2 / 3, -1 / 12])

    def at(offset):
        moved = np.array(x)
        moved[i] += offset
        return f(moved)

    return sum(w * (at(h) - at(-h)) for h, w in zip(offsets, weights))


def angular_first(jacobian):
    """The rows of a Jacobian in our order; with one joint Pinocchio returns a vector."""
    return np.roll(jacobian.reshape(6, -1), 3, axis=0)


class Robot:
    """A robot with a fixed base."""

    def __init__(self, urdf):
        self.model = pin.buildModelFromXML(urdf)
        self.data = self.model.createData()
        self.floating = pin.buildModelFromXML(urdf, pin.JointModelFreeFlyer())
        self.data_of_floating = self.floating.createData()
        joints = list(self.model.joints)[1:]
        self.n = len(joints)
        # A continuous joint has two numbers in Pinocchio, the cosine and the sine of its angle.
        self.on_circle = np.array([joint.nq == 2 for joint in joints], dtype=bool)
        self.index = np.array([joint.idx_q for joint in joints], dtype=int)
        self.turns = np.array([not joint.shortname().startswith("JointModelP") for joint in joints])
        self.links = [i for i, frame in enumerate(self.model.frames) if frame.type == pin.BODY]
        self.damping, self.friction, self.width = np.zeros(self.n), np.zeros(self.n), np.ones(self.n)

    def set_drives(self, damping, friction, width, armature):
        """Sets the rotor inertia, which Pinocchio has, and the losses, which its algorithms lack."""
        self.model.armature = armature
        self.damping, self.friction, self.width = damping, friction, width
        return {}

    def losses(self, v):
        """D v + F_c x / sqrt(1 + x^2) with x = v / v_0, and its first and second derivative in v."""
        x, steepness = v / self.width, self.friction / self.width
        root = np.hypot(1, x)
        return (
            self.damping * v + self.friction * x / root,
            self.damping + steepness / root**3,
            -3 * steepness / self.width * x / root**5,
        )

    def names(self):
        """The names of the joints and of the links, and the joints' parents."""
        return {
            "joints": list(self.model.names)[1:],
            "parents": [self.model.names[parent] for parent in list(self.model.parents)[1:]],
            "links": [self.model.frames[i].name for i in self.links],
        }

    def summary(self):
        """The number of joints, and of those whose subtree has no inertia."""
        mass = pin.crba(self.model, self.data, pin.neutral(self.model))
        return f"{self.n} joints, {np.count_nonzero(np.diag(mass) < 1e-12)} of them without inertia"

    def configuration(self, q):
        """Pinocchio's q."""
        p = np.empty(self.model.nq)
        p[self.index] = np.where(self.on_circle, np.cos(q), q)
        p[self.index[self.on_circle] + 1] = np.sin(q[self.on_circle])
        return p

    def without_losses(self, q, v, a):
        """ID without damping and friction, and its derivatives in q, v and a."""
        p = self.configuration(q)
        dq, dv, mass = pin.computeRNEADerivatives(self.model, self.data, p, v, a)
        square = (np.array(matrix).reshape(self.n, self.n) for matrix in (dq, dv, mass))
        return np.array(self.data.tau), *square

    def inverse_dynamics(self, q, v, a):
        """ID and its derivatives in q, v and a, the last of which is H."""
        tau, dq, dv, mass = self.without_losses(q, v, a)
        force, slope, _ = self.losses(v)
        return tau + force, dq, dv + np.diag(slope), mass

    def root_wrench(self, q, v, a):
        """The wrench of the root and its derivatives: the base rows of the robot on a floating base at rest."""
        model, data = self.floating, self.data_of_floating
        still = np.zeros(6)
        p = np.concatenate([pin.neutral(model)[:7], self.configuration(q)])
        v, a = np.concatenate([still, v]), np.concatenate([still, a])
        slopes = [np.array(slope) for slope in pin.computeRNEADerivatives(model, data, p, v, a)]
        return angular_first(np.array(data.tau)[:6]).ravel(), *(angular_first(slope[:6, 6:]) for slope in slopes)

    def mass_rate(self, q, qdot):
        """The rate of H along qdot: C + C^T, since H' - 2 C is skew."""
        coriolis = pin.computeCoriolisMatrix(self.model, self.data, self.configuration(q), qdot)
        coriolis = coriolis.reshape(self.n, self.n)
        return coriolis + coriolis.T

    def kinetic_energy(self, p, v):
        """That of the bodies and the rotors; Pinocchio leaves the rotors of joints with an oblique axis out."""
        armature = np.array(self.model.armature)
        self.model.armature = np.zeros(self.n)
        bodies = pin.computeKineticEnergy(self.model, self.data, p, v)
        self.model.armature = armature
        return bodies + armature @ v**2 / 2

    def dynamics(self, q, v, a, tau):
        """All quantities for which Pinocchio has a function."""
        model, data, p = self.model, self.data, self.configuration(q)
        losses, slope, _ = self.losses(v)
        axes = pin.computeJointJacobians(model, data, p)
        pin.framesForwardKinematics(model, data, p)
        at_link = [pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED) for i in self.links]
        everything = {
            "joint axes": angular_first(axes),
            "link Jacobians": np.vstack([angular_first(jacobian) for jacobian in at_link]),
            "joint placements": placements(list(data.oMi)[1:]),
            "link placements": placements(data.oMf[i] for i in self.links),
            "ID": pin.rnea(model, data, p, v, a),
            "C": pin.nonLinearEffects(model, data, p, v),
            "gravity": pin.computeGeneralizedGravity(model, data, p),
            "H": pin.crba(model, data, p),
            "Hdot": self.mass_rate(q, v),
            "FD": pin.aba(model, data, p, v, tau - losses),
            "kinetic energy": [self.kinetic_energy(p, v)],
            "potential energy": [pin.computePotentialEnergy(model, data, p)],
        }
        everything = {name: np.array(value) for name, value in everything.items()}
        everything["ID"] += losses
        everything["C"] += losses
        _, everything["dID/dq"], everything["dID/dv"], everything["dID/da"] = self.inverse_dynamics(q, v, a)
        names = ["root wrench", "droot/dq", "droot/dv", "droot/da"]
        everything |= zip(names, self.root_wrench(q, v, a))
        fd = pin.computeABADerivatives(model, data, p, v, tau - losses)
        everything |= zip(["dFD/dq", "dFD/dv", "dFD/dtau"], map(np.array, fd))
        everything["dFD/dv"] = everything["dFD/dv"] - everything["dFD/dtau"] * slope
        return everything

    def second_derivatives(self, q, v, a):
        """The second derivatives of inverse dynamics, by differences of Pinocchio's first ones.

        As a function of q_k, the kinetic energy is quadratic in velocities that contain one rotation or translation by
        q_k, and the potential energy is linear in it. So ID is of degree 2 in the sine and cosine of q_k, or in q_k
        of a prismatic joint, and so are its derivatives at most. In v it is of degree 2, too, without the losses.
        """

        first = lambda q, v: np.array(self.without_losses(q, v, a)[1:])
        by_q = [derivative(lambda q: first(q, v), q, i, self.turns[i], 2) for i in range(self.n)]
        by_v = [derivative(lambda v: first(q, v), v, i, False, 2) for i in range(self.n)]
        (dqdq, _, dadq), (dqdv, dvdv, _) = np.stack(by_q, axis=-1), np.stack(by_v, axis=-1)
        every = np.arange(self.n)
        dvdv[every, every, every] += self.losses(v)[2]
        tensors = {"d2ID/dqdq": dqdq, "d2ID/dadq": dadq, "d2ID/dqdv": dqdv, "d2ID/dvdv": dvdv}
        wrench = lambda q, v: np.tensordot(np.arange(1, 7), np.stack(self.root_wrench(q, v, a)[1:]), (0, 1))
        by_q = [derivative(lambda q: wrench(q, v), q, i, self.turns[i], 2) for i in range(self.n)]
        by_v = [derivative(lambda v: wrench(q, v), v, i, False, 2) for i in range(self.n)]
        (qq, _, aq), (qv, vv, _) = np.stack(by_q, axis=-1), np.stack(by_v, axis=-1)
        tensors |= {"d2root/dqdq": qq, "d2root/dqdv": qv, "d2root/dvdv": vv, "d2root/dqda": aq.T}
        return {name: tensor.ravel(order="F") for name, tensor in tensors.items()}

    def constraints(self, q):
        """The clearances of a ball of 0.1 m about the origin of every link from a sphere and a half-space: the values
        of the rows, then the gradient and the Hessian of their sum with the weights 1, 2, ...

        A position is of degree 1 in the sine and cosine of each angle, so its square is of degree 2.
        """
        centre, reach = np.array([0.3, -0.2, 0.5]), 0.1 + 0.25
        normal, offset = np.array([0.6, 0.0, 0.8]), 0.1 - 0.3

        def rows(q):
            model, data, p = self.model, self.data, self.configuration(q)
            pin.computeJointJacobians(model, data, p)
            pin.framesForwardKinematics(model, data, p)
            at = [data.oMf[i].translation.copy() for i in self.links]
            moved = [pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED) for i in self.links]
            moved = [jacobian.reshape(6, -1)[:3] for jacobian in moved]
            values = [reach**2 - (p - centre) @ (p - centre) for p in at] + [offset - normal @ p for p in at]
            slopes = [-2 * (p - centre) @ j for p, j in zip(at, moved)] + [-normal @ j for j in moved]
            return np.array(values), np.array(slopes)

        gradient = lambda q: rows(q)[1].T @ np.arange(1, 2 * len(self.links) + 1)
        hessian = [derivative(gradient, q, i, self.turns[i], 2) for i in range(self.n)]
        return {"g": rows(q)[0], "gradient": gradient(q), "Hessian": np.stack(hessian, axis=-1)}
