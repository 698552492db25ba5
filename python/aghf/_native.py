"""The compiled part: the build for processors with AVX2 if possible, otherwise the baseline.

A wheel has both; `pip install` of the sources builds only the first. The environment variable ``AGHF_BASELINE=1``
selects the baseline.
"""

import importlib.util
import os
import platform
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

#: The flags of the level x86-64-v3 beyond the baseline, as /proc/cpuinfo calls it.
NEEDED = {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}


def _has_avx2() -> bool:
    if platform.machine() != "x86_64" or not os.path.exists("/proc/cpuinfo"):
        # It was built for this machine.
        return True
    with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
        flags = next((line for line in file if line.startswith("flags")), "")
    return NEEDED <= set(flags.split())


def _baseline() -> Any:
    folder = Path(__file__).parent
    found = sorted(folder.glob("_aghf_baseline*.so"))
    if not found:
        raise ImportError(
            "this build of aghf needs a processor with AVX2: install a wheel, or build it on this machine with "
            "RUSTFLAGS='-C target-cpu=native'"
        )
    name = "aghf._aghf"
    specification = importlib.util.spec_from_file_location(name, found[0])
    if specification is None or specification.loader is None:
        raise ImportError(f"{found[0]} is no module")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    specification.loader.exec_module(module)
    return module


if TYPE_CHECKING:
    from . import _aghf as _aghf
elif os.environ.get("AGHF_BASELINE") == "1" or not _has_avx2():
    _aghf = _baseline()
else:
    from . import _aghf
