"""Common parts of the shooting methods of the paper's experiments: initial guesses, and knots as a motion."""

import numpy as np
import pinocchio as pin

from common import Motion


def rollout(model, start, controls, dt):
    """The states of semi-implicit Euler steps from a state, rows of positions and velocities."""
    n, data = model.nv, model.createData()
    states = [start]
    for u in controls:
        q, v = states[-1][:n], states[-1][n:]
        v = v + dt * pin.aba(model, data, q, v, u)
        states.append(np.r_[q + dt * v, v])
    return np.array(states)


def guess(model, values, name, dt):
    """A guess of the supplement by its name: states, and controls, of which there is one less."""
    n, data = model.nv, model.createData()
    count = round(values["horizon_s"] / dt)
    start, goal = (np.r_[values[f"q_{end}"], values[f"v_{end}"]] for end in ("start", "goal"))
    if name == "Line and RNEA":
        states = np.linspace(start, goal, count + 1)
        slope = (goal - start) / values["horizon_s"]
        return states, np.array([pin.rnea(model, data, x[:n], x[n:], slope[n:]) for x in states[:-1]])
    controls = np.zeros((count, n))
    if name in ("Constant", "Rollout and Constant"):
        controls[:] = pin.rnea(model, data, start[:n], start[n:], np.zeros(n))
    if name.startswith("Rollout"):
        return rollout(model, start, controls, dt), controls
    states = np.tile(start, (count + 1, 1))
    if name == "Zeros":
        states[1:] = 0.0
    return states, controls


def motion_of(model, states, controls, dt):
    """Knots with the torques that hold from each to the next, and the accelerations they lead to."""
    n, data = model.nv, model.createData()
    u = np.vstack([controls, controls[-1:]])
    a = np.array([pin.aba(model, data, x[:n], x[n:], w) for x, w in zip(states, u)])
    times = dt * np.arange(len(states))
    return Motion(times, states[:, :n], states[:, n:], a, u, hold=True, names=list(model.names)[1:])
