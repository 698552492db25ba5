"""Scenarios that are solved side by side, as a stream of results and in a folder."""

import json
import os
import signal
import sys
import threading
import time
import types

import aghf
import numpy as np
import pytest
from problems import SWING

REST = {"horizon_s": 3.0, "q_start": [0.0] * 5, "v_start": [0.0] * 5, "q_goal": [3.14] + [0.0] * 4, "v_goal": [0.0] * 5}
GOALS = {f"to {goal}": {**SWING, "q_goal": [goal, 0.5]} for goal in (0.6, 0.8, 1.0)}


def test_results_come_with_their_ids():
    problems = GOALS | {"short": {**SWING, "q_goal": [1.0]}}
    found = dict(aghf.solve_each(problems, starts=1, threads=2))
    assert found.keys() == problems.keys()
    assert isinstance(found["short"], aghf.InputError) and found["short"].element == "q_goal"
    for name, scenario in GOALS.items():
        one = aghf.solve(scenario, starts=1)
        assert np.array_equal(found[name].sample(7).q, one.sample(7).q)
    assert sorted(name for name, _ in aghf.solve_each([SWING, SWING], starts=1)) == [0, 1]


def test_a_folder_is_resumed(tmp_path):
    problems = GOALS | {"short": {**SWING, "q_goal": [1.0]}}
    stream = aghf.solve_each(problems, folder=tmp_path, threads=1, starts=1)
    first, solution = next(stream)
    stream.close()
    written = tmp_path / first / "summary.json"
    before = written.stat().st_mtime_ns
    assert json.loads(written.read_text())["control_effort"] == solution.summary["control_effort"]

    found = dict(aghf.solve_each(problems, folder=tmp_path, starts=1))
    assert found.keys() == problems.keys() and isinstance(found["short"], aghf.InputError)
    assert written.stat().st_mtime_ns == before
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(GOALS)
    assert found[first].summary == solution.summary

    problems["short"] = SWING
    mended = dict(aghf.solve_each(problems, folder=tmp_path, starts=1))
    assert all(isinstance(result, aghf.Solution) for result in mended.values())
    # A motion that was not written to its end is none, and one of another origin is not overwritten.
    written.unlink()
    again = dict(aghf.solve_each(problems, folder=tmp_path, starts=1))
    assert written.stat().st_mtime_ns > before and again[first].success
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "summary.json").write_text("{}")
    with pytest.raises(ValueError, match="other has a motion of another origin"):
        list(aghf.solve_each({"other": SWING}, folder=tmp_path))

    words = f"folder: .*{first} has the motion of another scenario or with other options"
    for changed, options in [({first: {**SWING, "horizon_s": 3.0}}, {"starts": 1}), ({first: GOALS[first]}, {})]:
        with pytest.raises(ValueError, match=words):
            list(aghf.solve_each(changed, folder=tmp_path, **options))
    # The order of options and keys does not matter, the text of a file does.
    again = dict(aghf.solve_each({first: dict(reversed(GOALS[first].items()))}, folder=tmp_path, seed=None, starts=1))
    assert again[first].success
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(SWING))
    list(aghf.solve_each({"file": str(path)}, folder=tmp_path / "files", starts=1))
    path.write_text(json.dumps({**SWING, "horizon_s": 3.0}))
    with pytest.raises(ValueError, match="file has the motion of another scenario"):
        list(aghf.solve_each({"file": str(path)}, folder=tmp_path / "files", starts=1))
    with pytest.raises(ValueError, match="scenarios: '1' is the id of two"):
        list(aghf.solve_each({1: SWING, "1": SWING}, folder=tmp_path))
    for name in ["..", "a/b", ""]:
        with pytest.raises(ValueError, match=f"scenarios: '{name}' is no name of a folder"):
            list(aghf.solve_each({name: SWING}, folder=tmp_path))


def test_a_bar_counts_the_results(monkeypatch):
    bars = []

    def tqdm(results, total, unit):
        bars.append((total, unit))
        return results

    monkeypatch.setitem(sys.modules, "tqdm", types.SimpleNamespace(tqdm=tqdm))
    assert len(list(aghf.solve_each([SWING] * 3, starts=1, progress=True))) == 3
    # The standard error of a test is no terminal.
    assert len(list(aghf.solve_each([SWING] * 3, starts=1))) == 3
    assert bars == [(3, "scenario")]


def test_the_searches_end_with_the_stream():
    hard = {f"{k}": {"robot": "pendulum_5", **REST} for k in range(3)}
    stream = aghf.solve_each({"easy": SWING, **hard}, starts=100_000, threads=1)
    began = time.monotonic()
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        list(stream)
    assert time.monotonic() - began < 20.0


def test_unknown_options_are_refused():
    for option in ["speed", "start", "constraints"]:
        with pytest.raises(TypeError, match=rf"solve_each\(\) got an unexpected keyword argument '{option}'"):
            aghf.solve_each([SWING], **{option: 1})
    with pytest.raises(ValueError, match="threads: it is 0"):
        list(aghf.solve_each([SWING], threads=0))
