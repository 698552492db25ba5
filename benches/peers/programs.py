"""The C++ program that uses a peer's headers, built by CMake."""

import subprocess
import sys
import sysconfig
from pathlib import Path

from common import HERE, WORK


def built(name, **definitions):
    """The program of the folder `name`, built if it is not up to date."""
    cmake = Path(sys.executable).parent / "cmake"
    folder = WORK / f"build_{name}"
    cmeel = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix"
    settings = [f"-D{key}={value}" for key, value in {"CMEEL": cmeel, **definitions}.items()]
    for command in ([cmake, "-S", HERE / name, "-B", folder, *settings], [cmake, "--build", folder]):
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"{name} does not build:\n{run.stdout}\n{run.stderr}")
    return folder / f"{name}_plan"
