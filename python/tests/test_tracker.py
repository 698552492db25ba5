"""A motion that is followed and replanned."""

import numpy as np
import pytest

import aghf
from problems import SWING

BALL = {"shape": {"sphere": {"radius_m": 0.1}}, "pose": {"position_m": [5.0, 0.0, 0.0]}}


def test_a_tracker_follows_its_plan_to_a_moved_goal():
    tracker = aghf.Tracker({**SWING, "obstacles": [BALL]}, search={"degree": 9}, iterations_per_step=2)
    q, v, iterations, replaced = np.zeros(2), np.zeros(2), 0, 0
    goal = np.array([1.2, 0.4])
    for k in range(1000):
        if k == 50:
            tracker.set_goal(goal, 1.5)
        step = tracker.step(q, v, 0.004 * k)
        command = step.command
        assert step.safety == "kept" and step.violation is None and not step.cut_off
        assert command.gain.shape == (2, 4) and command.tau.shape == (2,)
        q, v = command.q, command.v
        iterations, replaced = iterations + step.iterations, replaced + step.replaced
        if k > 50 and step.outcome == "finished":
            break
    assert step.outcome == "finished" and iterations > 50 and replaced > 0
    assert np.abs(q - goal).max() < 1e-9 and np.abs(v).max() < 1e-9


def test_the_command_is_the_feedback_on_the_plan():
    tracker = aghf.Tracker(SWING, search={"degree": 9}, deadline_s=0.0)
    tracker.step([0.0, 0.0], [0.0, 0.0], 0.0)
    off = np.array([0.01, -0.02, 0.03, 0.04])
    plan = tracker.step([0.0, 0.0], [0.0, 0.0], 0.5).command
    step = tracker.step(plan.q + off[:2], plan.v + off[2:], 0.5)
    assert step.cut_off and step.iterations == 0 and step.deviation == pytest.approx(0.02)
    command, model = step.command, aghf.Model.builtin("pendulum_2")
    assert np.allclose(command.tau, aghf.rnea(model, command.q, command.v, command.a), atol=1e-9)
    assert np.allclose(command.u, command.tau - command.gain @ off, atol=1e-9)
    found = aghf.rnea_derivatives(model, command.q, command.v, command.a)
    assert np.allclose(command.gain, np.hstack([900.0 * found.da - found.dq, 60.0 * found.da - found.dv]), atol=1e-8)


def test_an_obstacle_on_the_plan_is_named():
    tracker = aghf.Tracker({**SWING, "robot_shape": "joint_frames"}, search={"degree": 9}, deadline_s=0.0)
    assert tracker.step([0.0, 0.0], [0.0, 0.0], 0.0).safety == "kept"
    model = aghf.Model.builtin("pendulum_2")
    place = aghf.forward_kinematics(model, np.array([0.5, 0.25]))[-1][:3, 3]
    tracker.set_obstacles([{**BALL, "pose": {"position_m": place}}])
    step = tracker.step([0.0, 0.0], [0.0, 0.0], 0.0)
    assert step.safety == "violated"
    violation = step.violation
    assert "sphere" in violation.row and violation.unit == "m" and violation.by > 1e-3 and violation.after_s < 2.0
    tracker.set_obstacles([])
    assert tracker.step([0.0, 0.0], [0.0, 0.0], 0.0).safety == "kept"


def test_the_rest_of_a_plan_is_a_motion_for_the_judge():
    tracker = aghf.Tracker(SWING, search={"degree": 9})
    q, v, now = np.zeros(2), np.zeros(2), 0.0
    for now in (0.0, 0.25, 0.5):
        command = tracker.step(q, v, now).command
        q, v = command.q, command.v
    rest = tracker.rest()
    assert rest.t[0] == 0.0 and rest.t[-1] == pytest.approx(SWING["horizon_s"] - now)
    assert np.allclose(rest.q[0], q) and np.allclose(rest.v[0], v) and np.allclose(rest.tau[0], command.tau)
    own = {**SWING, "horizon_s": rest.t[-1], "q_start": q, "v_start": v}
    found = aghf.judge(own, *rest)
    assert found["valid"] and found["verdict"] == "valid" and "quintics" in found["between_samples"]
    assert {"velocity limits", "torque limits"} <= {check["check"].replace("_", " ") for check in found["checks"]}
    assert not aghf.judge(SWING, *rest)["valid"]


def test_samples_from_any_source_are_judged():
    solution = aghf.solve(SWING)
    t, q, v, a, tau = solution.sample(400)
    assert aghf.judge(SWING, t, q, v, a, tau)["valid"]
    alone = aghf.judge(SWING, t, q)
    assert alone["verdict"] in ("valid", "valid_in_part") and "rates of q" in alone["between_samples"]
    wrong = aghf.judge(SWING, t, q, v, a, 1.1 * tau)
    assert [check["check"] for check in wrong["checks"] if check["outcome"] == "fail"] != []
    assert aghf.judge(SWING, t, q, v, a, 1.1 * tau, tolerance=1.0)["valid"]
    with pytest.raises(ValueError, match=r"q: its shape is \[399, 2\], \(400, 2\) is needed"):
        aghf.judge(SWING, t, q[1:])
    with pytest.raises(aghf.InputError, match="does not come after"):
        aghf.judge(SWING, t[::-1], q)
    with pytest.raises(aghf.InputError, match="tau.*NaN is no finite number"):
        aghf.judge(SWING, t, q, v, a, np.nan * tau)
    with pytest.raises(aghf.InputError, match="t.*inf is no finite number"):
        aghf.judge(SWING, np.append(t[:-1], np.inf), q)
    with pytest.raises(aghf.InputError, match="at least 2"):
        aghf.judge(SWING, t[:1], q[:1])
    with pytest.raises(aghf.InputError, match="tolerance"):
        aghf.judge(SWING, t, q, tolerance=-1.0)


def test_a_deadline_may_change():
    tracker = aghf.Tracker(SWING, search={"degree": 9})
    assert not tracker.step([0.0, 0.0], [0.0, 0.0], 0.0).cut_off
    tracker.set_deadline(0.0)
    assert tracker.step([0.0, 0.0], [0.0, 0.0], 0.1).cut_off
    tracker.set_deadline(None)
    assert not tracker.step([0.0, 0.0], [0.0, 0.0], 0.2).cut_off
    with pytest.raises(ValueError, match="deadline_s: it is -1"):
        tracker.set_deadline(-1.0)


def test_bad_input_is_refused_by_name():
    with pytest.raises(TypeError, match="speed"):
        aghf.Tracker(SWING, speed=1.0)
    with pytest.raises(aghf.InputError, match="bandwidth"):
        aghf.Tracker(SWING, bandwidth=-1.0)
    with pytest.raises(aghf.InputError, match="joint 0 is not at rest"):
        aghf.Tracker({**SWING, "v_goal": [0.1, 0.0]})
    tracker = aghf.Tracker(SWING, search={"degree": 9})
    with pytest.raises(aghf.InputError, match="shortest"):
        tracker.set_goal([0.0, 0.0], 0.01)
    with pytest.raises(ValueError, match="q: expected 2 entries, found 1"):
        tracker.set_goal([0.0], 1.0)
    with pytest.raises(ValueError, match="q: expected 2 entries, found 1"):
        tracker.step([0.0], [0.0, 0.0, 0.0], 0.0)
    with pytest.raises(ValueError, match="obstacles: missing field `pose`"):
        tracker.set_obstacles([{"shape": BALL["shape"]}])
    tracker.step([0.0, 0.0], [0.0, 0.0], 1.0)
    with pytest.raises(aghf.InputError, match="before the last step"):
        tracker.step([0.0, 0.0], [0.0, 0.0], 0.5)
