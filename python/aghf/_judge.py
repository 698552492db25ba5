"""The judgement of motions, and the clearance of configurations."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
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


class Clearance(NamedTuple):
    """The closest pair of a configuration, or those of several."""

    #: The distance, m, negative in an overlap; ``(B,)`` for several configurations. Infinity if no pairs keep clear.
    distance_m: np.ndarray
    #: A link and an obstacle or another link, or a list with those of each configuration. None if no pairs keep clear.
    pair: tuple[str, str] | None | list[tuple[str, str] | None]


def clearance(scenario: str | os.PathLike[str] | Mapping[str, Any], q: ArrayLike) -> Clearance:
    """The distance of a robot from the obstacles and itself, with the nearest pair.

    The pairs are those that keep clear in motions of the scenario, its margins are not taken off. Where a pair
    overlaps, the distance is the negative depth or less. Cost: a distance per pair that may be the nearest; large
    batches use all cores. The scenario and its meshes are read once per call.

    Parameters
    ----------
    scenario : str, os.PathLike or Mapping
        As for `solve`.
    q : (N,) or (B, N)
        One configuration or several.

    Raises
    ------
    InputError, ValueError
        Names the scenario or the argument, and its fault.
    """
    given = array(q, "q")
    found = _aghf.clearance(named(scenario), given)
    pairs = [(own[0], own[1]) if own is not None else None for _, own in found]
    distances = np.array([distance for distance, _ in found])
    return Clearance(distances[0], pairs[0]) if given.ndim == 1 else Clearance(distances, pairs)
