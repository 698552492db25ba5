"""The types of the compiled part."""

import subprocess
import sys


def test_the_stub_has_the_types_of_the_compiled_part(tmp_path):
    command = [sys.executable, "-m", "mypy.stubtest", "aghf._aghf"]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 0, run.stdout + run.stderr
