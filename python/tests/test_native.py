"""The module for older processors has the same numbers as the other."""

import os
import subprocess
import sys

import pytest

SCRIPT = """
import numpy as np, aghf
model = aghf.Model.builtin("kinova_gen3")
q, v, a = np.random.default_rng(0).normal(size=(3, 100, 7))
print(repr(aghf._aghf), aghf.rnea_derivatives(model, q, v, a).dq.tobytes().hex())
print(aghf.solve("pendulum_2_swingup").summary["control_effort"])
"""


@pytest.mark.skipif(os.environ.get("AGHF_WHEEL") != "whole", reason="AGHF_WHEEL=whole builds the other module")
def test_both_modules_have_the_same_numbers():
    told = []
    for baseline in ["0", "1"]:
        environment = {**os.environ, "AGHF_BASELINE": baseline}
        command = [sys.executable, "-c", SCRIPT]
        run = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
        assert ("baseline" in run.stdout) == (baseline == "1"), run.stdout[:200]
        told.append(run.stdout.split("'> ")[-1].split(">")[-1])
    assert told[0] == told[1]
