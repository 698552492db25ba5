"""Solving: results, callbacks, interrupts, many at once, and errors."""

import copy
import inspect
import json
import os
import pickle
import signal
import subprocess
import threading
import time
from concurrent.futures import CancelledError

import numpy as np
import pytest

import aghf
from problems import SWING


def test_a_motion_keeps_its_ends_and_its_dynamics():
    solution = aghf.solve(SWING)
    assert solution.success and solution.horizon == 2.0
    motion = solution.sample(101)
    assert motion.q.shape == (101, 2)
    assert np.allclose(motion.q[[0, -1]], [[0, 0], [1, 0.5]], atol=1e-12)
    assert np.allclose(motion.v[[0, -1]], 0, atol=1e-12)
    assert np.array_equal(motion.tau, aghf.rnea(solution.model, motion.q, motion.v, motion.a))
    assert solution.minima[0]["cost"] == pytest.approx(solution.summary["control_effort"], rel=1e-4)
    one = solution.evaluate(1.0)
    assert one.q.shape == (2,) and np.allclose(one.q, motion.q[50])
    with pytest.raises(ValueError, match="from 0 to 2 s"):
        solution.evaluate(2.5)
    assert solution.scenario["q_goal"] == [1.0, 0.5]


def test_arrays_are_part_of_a_scenario_and_options_have_the_names_of_the_program():
    scenario = {**SWING, "q_goal": np.array([1.0, 0.5]), "horizon_s": np.float64(2.0)}
    told = []
    solution = aghf.solve(scenario, starts=2, seed=7, degree=9, on_iteration=told.append)
    options = solution.summary["provenance"]["options"]
    assert (options["starts"], options["seed"], options["degree"]) == (2, 7, 9)
    assert {"start", "degree", "cost", "gradient_norm"} <= told[0].keys()
    assert {record["start"] for record in told} >= {0, 1}
    rested = []
    aghf.solve("pendulum_2_swingup", method="rest", on_iteration=rested.append)
    s = [record["s"] for record in rested]
    assert s == sorted(s) and s[0] < s[-1]
    by_flow = aghf.solve("pendulum_2_swingup", method="flow")
    assert by_flow.success and by_flow.verdict == "at s_max"
    assert by_flow.summary["method"] == "flow" and by_flow.minima == []


def test_the_files_of_a_solve(tmp_path):
    solution = aghf.solve(SWING, starts=1)
    files = solution.save(tmp_path / "out")
    assert sorted(os.path.basename(file) for file in files) == ["report.html", "summary.json", "trajectory.csv"]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["control_effort"] == solution.summary["control_effort"]
    with pytest.raises(aghf.InputError, match="exists already"):
        solution.save(tmp_path / "out")
    solution.save(tmp_path / "out", replace=True)
    assert solution.report_html().lstrip().lower().startswith("<!doctype html>")
    assert solution._repr_html_().startswith("<iframe srcdoc=")


def test_what_a_callback_raises_ends_the_search():
    def stop(record):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        aghf.solve("kinova_free_01", starts=64, on_iteration=stop)


def test_control_c_keeps_the_best_motion_so_far():
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    solution = aghf.solve("kinova_free_01", starts=10_000)
    assert time.monotonic() - began < 30
    assert solution.success
    assert any("interrupted" in note for note in solution.summary["notes"])


def test_control_c_keeps_what_is_done_of_many():
    began = time.monotonic()
    aghf.solve_many(["kinova_free_01"] * 10)
    ten = time.monotonic() - began
    threading.Timer(ten, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    began = time.monotonic()
    found = aghf.solve_many(["kinova_free_01"] * 400)
    # All of them would take forty times as long as ten.
    assert time.monotonic() - began < 20 * ten
    done = [solution for solution in found if isinstance(solution, aghf.Solution)]
    assert len(found) == 400 and done and all(solution.success for solution in done)
    left = [each for each in found if not isinstance(each, aghf.Solution)]
    assert left and all(isinstance(each, CancelledError) for each in left)
    assert str(left[0]) == "kinova_free_01: Ctrl-C came before its solve began"


def test_a_bad_scenario_among_many_has_an_error_of_its_own():
    good, bad, missing = aghf.solve_many([SWING, {**SWING, "q_goal": [1.0]}, "nothing"], starts=1)
    assert isinstance(good, aghf.Solution) and good.success
    assert isinstance(bad, aghf.InputError) and (bad.file, bad.element) == ("scenario", "q_goal")
    assert isinstance(missing, aghf.InputError) and missing.file == "nothing"
    again = pickle.loads(pickle.dumps(bad))
    assert isinstance(again, aghf.InputError) and again.element == "q_goal"


def test_the_signature_has_every_option_of_the_program():
    program = [os.environ["AGHF_PROGRAM"], "scenarios", "--schema", "options"]
    schema = json.loads(subprocess.run(program, capture_output=True, text=True, check=True).stdout)
    methods = {each["properties"]["method"]["const"]: each["properties"].keys() for each in schema["oneOf"]}
    options = set().union(*methods.values())
    for function, own, expected in [
        (aghf.solve, {"scenario", "running_cost", "constraints", "on_iteration", "start"}, options),
        (aghf.solve_many, {"scenarios"}, options),
        (aghf.tradeoff, {"scenario", "points"}, methods["direct"] - {"method"}),
    ]:
        assert inspect.signature(function).parameters.keys() - own == expected, function


@pytest.mark.parametrize("function", [aghf.solve, aghf.solve_many, aghf.tradeoff])
def test_an_unknown_option_is_a_type_error(function):
    with pytest.raises(TypeError, match=rf"{function.__name__}\(\) got an unexpected keyword argument 'speed'"):
        function(SWING, speed=1)


def test_solutions_are_pickled_and_copied():
    solution = aghf.solve(SWING, starts=1)
    motion = solution.sample(11)
    for again in [pickle.loads(pickle.dumps(solution)), copy.copy(solution), copy.deepcopy(solution)]:
        assert again.summary == solution.summary and again.scenario == solution.scenario
        # The curve is stored by its coefficients.
        assert np.allclose(again.sample(11).q, motion.q, atol=1e-14)
        assert again.report_html().lstrip().lower().startswith("<!doctype html>")
        assert aghf.solve(SWING, start=again).success
    model = pickle.loads(pickle.dumps(solution.model))
    assert np.array_equal(aghf.rnea(model, motion.q, motion.v, motion.a), motion.tau)
    goal = pickle.loads(pickle.dumps(aghf.Goal("tool", tolerance_m=0.1)))
    assert goal == {"frame": "tool", "tolerance_m": 0.1} and isinstance(goal, aghf.Goal)


def test_motions_of_several_solutions_are_stacked():
    solutions = aghf.solve_many([SWING, "pendulum_2_swingup"], starts=1)
    motions = aghf.stack(solutions, 11)
    assert motions.t.shape == (2, 11)
    assert all(part.shape == (2, 11, 2) for part in motions[1:])
    for i, solution in enumerate(solutions):
        assert all(np.array_equal(all_of[i], own) for all_of, own in zip(motions, solution.sample(11), strict=True))
    for wrong in [[], [*solutions, aghf.solve("pendulum_1_swingup", starts=1)]]:
        with pytest.raises(ValueError, match="solutions: their numbers of joints are"):
            aghf.stack(wrong)


def test_the_clearance_of_configurations():
    def scene(radius):
        ball = {"shape": {"sphere": {"radius_m": radius}}, "pose": {"position_m": [0.6, 0.0, 0.4]}, "name": "ball"}
        rest = {"v_start": [0.0] * 7, "q_start": [0.0] * 7, "q_goal": [0.5] * 7, "v_goal": [0.0] * 7, "horizon_s": 2.0}
        return {"robot": "kinova_gen3", "obstacles": [ball] if radius else []} | rest

    scenario = scene(0.1)
    rng = np.random.default_rng(20261130)
    q = rng.uniform(-1.5, 1.5, (70, 7))
    found = aghf.clearance(scenario, q)
    assert found.distance_m.shape == (70,)
    for own, distance, pair in zip(q[::9], found.distance_m[::9], found.pair[::9], strict=True):
        one = aghf.clearance(scenario, own)
        assert one.distance_m == distance and one.pair == pair
    # Another ball is nearer by the difference of the radii where the ball is the nearest.
    larger = aghf.clearance(scene(0.101), q)
    by_ball = (found.distance_m > 0.0) & [pair[1] == "ball" for pair in found.pair]
    assert any(by_ball)
    np.testing.assert_allclose((found.distance_m - larger.distance_m)[by_ball], 1e-3, atol=1e-9)

    alone = aghf.clearance(scene(None) | {"self_collision": "off"}, q[0])
    assert alone.distance_m == np.inf and alone.pair is None
    with pytest.raises(ValueError, match=r"q: its shape is \[2, 3\]"):
        aghf.clearance(scenario, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="q: entry 6 of number 1 is not finite"):
        aghf.clearance(scenario, [[0.0] * 7, [0.0] * 6 + [np.nan]])


def test_many_are_those_one_by_one():
    names = ["pendulum_2_swingup", "limits_03", SWING]
    many = aghf.solve_many(names, starts=2)
    for name, solution in zip(names, many, strict=True):
        one = aghf.solve(name, starts=2)
        assert one.summary["control_effort"] == solution.summary["control_effort"]


def test_bad_scenarios_and_options_are_errors():
    with pytest.raises(aghf.InputError) as raised:
        aghf.solve({**SWING, "q_goal": [1.0]})
    assert (raised.value.file, raised.value.element) == ("scenario", "q_goal")
    for scenario, words in [
        ("nothing", "neither a file nor a built-in scenario"),
        ({**SWING, "horizon": 1}, "horizon"),
        ({**SWING, "horizon_s": -1}, "horizon_s"),
        ({}, "robot"),
        ({**SWING, "q_goal": [float("nan"), 0]}, "scenario"),
    ]:
        with pytest.raises(aghf.InputError, match=words):
            aghf.solve(scenario)
    for options, words in [
        ({"degree": "high"}, "options"),
        ({"method": "magic"}, "magic"),
        ({"starts": 0}, "starts"),
    ]:
        with pytest.raises(ValueError, match=words):
            aghf.solve(SWING, **options)
    with pytest.raises(TypeError):
        aghf.solve(None)
    with pytest.raises(TypeError):
        aghf.solve({**SWING, "q_goal": object()})


ARM = {
    "robot": "kinova_gen3",
    "horizon_s": 1.6,
    "robot_shape": "joint_frames",
    "q_start": [0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0],
    "v_start": [0.0] * 7,
    "v_goal": [0.0] * 7,
    "enforced_limits": {"position": True, "velocity": True, "torque": True},
}


def test_a_solve_starts_from_another_one():
    goal = np.array([1.4, 0.9, 0.0, 1.9, 0.0, 0.9, 0.0])
    first = aghf.solve(ARM | {"q_goal": list(goal)})
    moved = ARM | {"q_goal": list(goal + 0.01)}
    cold, warm = aghf.solve(moved), aghf.solve(moved, start=first)
    assert warm.summary["iterations"] < cold.summary["iterations"]
    assert warm.summary["cost"] == pytest.approx(cold.summary["cost"], rel=2e-3)
    assert any("with its multipliers" in note for note in warm.summary["notes"])
    with pytest.raises(aghf.InputError, match="only the direct method"):
        aghf.solve(moved, start=first, method="rest")


def test_a_goal_is_a_set_of_poses():
    goal = aghf.Goal("end_effector_link", position_m=np.array([0.4, 0.1, 0.3]), tolerance_m=0.01)
    assert goal == {"frame": "end_effector_link", "position_m": [0.4, 0.1, 0.3], "tolerance_m": 0.01}
    arm = {key: value for key, value in ARM.items() if key != "v_goal"} | {"horizon_s": 3.0}
    solution = aghf.solve(arm | {"goal": goal})
    assert solution.success and solution.scenario["goal"] == [goal]
    placement = aghf.frame_placement(solution.model, solution.evaluate(3.0).q, "end_effector_link")
    position = placement[:3, 3]
    assert np.linalg.norm(position - [0.4, 0.1, 0.3]) < 0.01 + 1e-6


def test_less_time_costs_more_effort():
    found = aghf.tradeoff("limits_01", points=3, threads=1)
    table = found.table
    assert set(table["verdict"]) <= {"optimal", "valid"} and len(found.solutions) == 3
    assert table["duration_s"] == sorted(table["duration_s"])
    assert table["control_effort"] == sorted(table["control_effort"], reverse=True)
    assert "A click on a point shows its motion" in found.report_html()
    with pytest.raises(aghf.InputError, match="points: it is 1"):
        aghf.tradeoff("limits_01", points=1)
