"""The right-hand side of the flow and its Jacobian by their definition (7), from Pinocchio's quantities.

    Omega = G^-1 F,  F = d/dt dL/dxdot - dL/dx,  L = k |xdot_P1 - x_P2|^2 + |u|^2,  G = blockdiag(k I, H H)

with u = ID(x_P1, x_P2, xdot_P2). A node is z = [x, xdot, xddot], 6 N numbers.
"""

import numpy as np


def forces(robot, z):
    """F in two parts: that of |xdot_P1 - x_P2|^2, to be multiplied by k, and that of |u|^2; and H."""
    q, v, qdot, a, qddot, adot = z.reshape(6, -1)
    u, dq, dv, mass = robot.inverse_dynamics(q, v, a)
    u_rate = dq @ qdot + dv @ a + mass @ adot
    slip = np.append(2 * (qddot - a), 2 * (qdot - v))
    momentum_rate = 2 * (robot.mass_rate(q, qdot) @ u + mass @ u_rate)
    return slip, np.append(-2 * dq.T @ u, momentum_rate - 2 * dv.T @ u), mass


def divided(mass, slip, effort, k):
    """G^-1 (k slip + effort)."""
    n = len(mass)
    lower = np.linalg.solve(mass, np.linalg.solve(mass, k * slip[n:] + effort[n:]))
    return np.append(slip[:n] + effort[:n] / k, lower)


def omega(robot, z, k):
    slip, effort, mass = forces(robot, z)
    return {"Omega": divided(mass, slip, effort, k[0])}


def jacobian(robot, z, k):
    """Column i is G^-1 (dF/dz_i - dG/dz_i Omega).

    u, its derivatives and H are of degree 2 in every entry of q (see `Robot.second_derivatives`), u and dID/dq also in
    v, and each term of F is a product of at most two of these: degree 4.
    """
    n = robot.n
    slip, effort, mass = forces(robot, z)
    at_z = divided(mass, slip, effort, k[0])
    columns = []
    for i in range(6 * n):
        turns = i < n and robot.turns[i]
        by_slip, by_effort = derivative(lambda z: np.array(forces(robot, z)[:2]), z, i, turns, 4)
        if i < n:
            by_mass = derivative(lambda z: forces(robot, z)[2], z, i, turns, 2)
            by_effort[n:] -= (by_mass @ mass + mass @ by_mass) @ at_z[n:]
        columns.append(divided(mass, by_slip, by_effort, k[0]))
    dx, dxdot, dxddot = np.split(np.column_stack(columns), 3, axis=1)
    return {"dx": dx, "dxdot": dxdot, "dxddot": dxddot}
