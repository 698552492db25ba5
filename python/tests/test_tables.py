"""Checks and sweeps as tables."""

import numpy as np
import pytest

import aghf


def test_the_check_of_a_robot():
    table = aghf.check(aghf.Model.builtin("pendulum_2"), samples=2)
    assert all(table["passes"]) and "inverse dynamics: d/dq" in table["quantity"]
    frame = table.to_pandas()
    assert len(frame) == len(table["quantity"]) and frame["error"].max() < 1e-6
    assert table.to_polars().height == len(frame)
    with pytest.raises(aghf.InputError, match="samples"):
        aghf.check(aghf.Model.builtin("pendulum_2"), samples=0)


def test_a_sweep(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(
        'method = "direct"\nscenarios = ["pendulum_2_swingup"]\ndegree = [9, 12]\nstarts = [1]\ntime_limit_s = 60\n',
        encoding="utf-8",
    )
    table = aghf.sweep(path, threads=2)
    frame = table.to_pandas()
    assert (frame["outcome"] == "success").all() and len(frame) == 2
    assert np.isfinite(frame["control_effort"]).all()
    assert table.rows()[0]["scenario"] == "pendulum_2_swingup"
    with pytest.raises(aghf.InputError, match="nothing"):
        aghf.sweep("nothing")
