"""The module for older processors has the same numbers as the other."""

import json
import os
import subprocess
import sys

import pytest

SCRIPT = """
import json
import numpy as np, aghf
model = aghf.Model.builtin("kinova_gen3")
q, v, a = np.random.default_rng(0).normal(size=(3, 100, 7))
derivatives = aghf.rnea_derivatives(model, q, v, a).dq.tobytes().hex()
effort = aghf.solve("pendulum_2_swingup").summary["control_effort"]
print(json.dumps([aghf._aghf.__file__, derivatives, effort]))
"""


@pytest.mark.skipif(os.environ.get("AGHF_WHEEL") != "whole", reason="AGHF_WHEEL=whole builds the other module")
def test_both_modules_have_the_same_numbers(tmp_path):
    told = []
    for baseline in ["0", "1"]:
        environment = {**os.environ, "AGHF_BASELINE": baseline}
        command = [sys.executable, "-c", SCRIPT]
        run = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path)
        assert run.returncode == 0, run.stderr
        file, derivatives, effort = json.loads(run.stdout)
        assert ("baseline" in file) == (baseline == "1"), file
        told.append((derivatives, effort))
    (ours, effort), (theirs, baseline) = told
    assert ours == theirs
    # Products of large matrices have other kernels there.
    assert effort == pytest.approx(baseline, rel=1e-9)
