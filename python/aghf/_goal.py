"""Goals that are sets of poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


class Goal(dict[str, Any]):
    """A set of poses of a frame, for the key ``goal`` of a scenario or ``poses`` in ``keep`` and ``waypoints``.

    At least one of `position_m`, `box`, `orientation_xyzw` and `axis` is needed; the scenario refuses any other set.

    Parameters
    ----------
    frame : str
        The link.
    position_m : (3,), optional
        The position of its origin, m.
    tolerance_m : float, optional
        The largest distance from it, m; by default zero.
    box : Mapping, optional
        A box of positions instead: ``{"size_m": [x, y, z], "pose": {"position_m": ..., "orientation_xyzw": ...}}``.
    orientation_xyzw : (4,), optional
        The unit quaternion of the frame.
    axis : Mapping, optional
        An axis of the frame and its direction instead: ``{"of_frame": [0, 0, 1], "direction": [0, 0, -1]}``.
    tolerance_rad : float, optional
        The largest angle from the orientation or the direction, rad; by default zero.
    relative_to : str, optional
        The link in whose axes all this is; by default the base.
    """

    def __init__(
        self,
        frame: str,
        *,
        position_m: Sequence[float] | np.ndarray | None = None,
        tolerance_m: float | None = None,
        box: Mapping[str, Any] | None = None,
        orientation_xyzw: Sequence[float] | np.ndarray | None = None,
        axis: Mapping[str, Any] | None = None,
        tolerance_rad: float | None = None,
        relative_to: str | None = None,
    ) -> None:
        keys = {
            "frame": frame,
            "position_m": _floats(position_m),
            "tolerance_m": tolerance_m,
            "box": box,
            "orientation_xyzw": _floats(orientation_xyzw),
            "axis": axis,
            "tolerance_rad": tolerance_rad,
            "relative_to": relative_to,
        }
        super().__init__({key: value for key, value in keys.items() if value is not None})


def _floats(values: Sequence[float] | np.ndarray | None) -> list[float] | None:
    return None if values is None else [float(value) for value in values]
