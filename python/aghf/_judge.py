"""The judgement of motions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from ._json import named, read
from ._model import array
from ._native import _aghf


def judge(
    scenario: str | os.PathLike[str] | Mapping[str, Any],
    t: ArrayLike,
    q: ArrayLike,
    v: ArrayLike | None = None,
    a: ArrayLike | None = None,
    tau: ArrayLike | None = None,
    *,
    tolerance: float = 1e-3,
    overlap_m: float = 1e-4,
) -> dict[str, Any]:
    """Judges whether samples from any source are a motion of a scenario, as ``aghf judge`` does.

    The judge shares model, dynamics and distances with the optimiser, and nothing else; between the samples a motion is
    the quintics through ``q``, ``v`` and ``a``, without ``a`` the cubics through ``q`` and ``v``, and limits and
    clearances are proved there too. ``judge(scenario, *samples)`` judges `Samples`.

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        As for `solve`.
    t : (T,)
        The times, ascending, s.
    q : (T, N)
        The positions.
    v, a, tau : (T, N), optional
        The velocities, accelerations, which need velocities, and torques. What depends on rates that the positions
        alone do not determine is not checked.
    tolerance : float
        The accepted deviation of everything but clearances, absolute, or relative to the largest torque.
    overlap_m : float
        The accepted depth of balls of the robot in obstacles or in each other, m.

    Returns
    -------
    dict
        ``valid``, ``verdict``, which is ``valid``, ``valid_in_part`` if some checks are not made, or ``not_valid``, the
        motion ``between_samples`` in words, and the ``checks`` with their outcomes and worst values: the contents of
        the file that ``aghf judge --json`` writes.

    Raises
    ------
    InputError, ValueError
        Names the scenario or the argument, and its fault.
    """
    given = {"q": q, "v": v, "a": a, "tau": tau}
    tables = [None if x is None else array(x, name) for name, x in given.items()]
    return read(_aghf.judge(named(scenario), array(t, "t"), tables, [tolerance, overlap_m]))
