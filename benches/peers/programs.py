"""The C++ programs that use peers' headers, built by CMake, and environments of their own for them."""

import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

from common import HERE, WORK

# Where the wheels of an environment put headers and libraries, below the folder of the environment.
CMEEL = Path(sysconfig.get_paths()["purelib"]).relative_to(sys.prefix) / "cmeel.prefix"


def quietly(*command):
    """Runs a command, whose output is in the error if it fails."""
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))} fails:\n{run.stdout}\n{run.stderr}")


def environment(name):
    """The environment of the wheels that `requirements.txt` of the folder `name` pins, made if it is not up to date."""
    folder, wanted = WORK / f"venv_{name}", HERE / name / "requirements.txt"
    made = folder / "requirements.txt"
    if not made.exists() or made.read_bytes() != wanted.read_bytes():
        venv.create(folder, clear=True, with_pip=True)
        quietly(folder / "bin" / "pip", "install", "--quiet", "--requirement", wanted)
        made.write_bytes(wanted.read_bytes())
    return folder


def built(name, prefix=sys.prefix, **definitions):
    """The program of the folder `name` with the wheels of the environment `prefix`, built if it is not up to date."""
    cmake = Path(sys.executable).parent / "cmake"
    folder = WORK / f"build_{name}"
    settings = [f"-D{key}={value}" for key, value in {"CMEEL": Path(prefix) / CMEEL, **definitions}.items()]
    quietly(cmake, "-S", HERE / name, "-B", folder, *settings)
    quietly(cmake, "--build", folder)
    return folder / f"{name}_plan"
