"""Robots."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._json import text
from ._native import _aghf


class Model:
    """A robot: a tree of rigid bodies with one joint each.

    It never changes, and can be pickled: a robot of a file is read from it again.

    Attributes
    ----------
    name : str
        The name of the robot.
    dof : int
        The number of joints, ``N``.
    mass : float
        The moving mass, kg.
    joint_names, joint_kinds, frame_names : list of str
    parents : numpy.ndarray, shape (N,)
        The parent of each joint, -1 for the base.
    lower, upper, velocity_limits, effort_limits : numpy.ndarray, shape (N,)
        The limits of each joint; infinite without a limit.
    gravity : numpy.ndarray, shape (3,)
    notes : list of str
        Notes on omitted or changed elements of the file.
    """

    def __init__(self, own: _aghf.Model, source: tuple[Any, ...]) -> None:
        self._own, self._source = own, source

    @classmethod
    def _made(cls, constructor: str, *arguments: Any) -> Model:
        """The robot of a constructor of the compiled part, which makes it again where it is unpickled."""
        return cls(getattr(_aghf.Model, constructor)(*arguments), (cls._made, (constructor, *arguments)))

    def __reduce__(self) -> tuple[Any, ...]:
        return self._source

    def __copy__(self) -> Model:
        return self

    def __deepcopy__(self, memo: object) -> Model:
        return self

    @classmethod
    def from_urdf(
        cls,
        path_or_text: str | os.PathLike[str],
        *,
        mimic: str = "refuse",
        root: str | None = None,
        losses: bool | Mapping[str, float | Mapping[str, float]] = False,
        packages: Mapping[str, str | os.PathLike[str]] | None = None,
    ) -> Model:
        """Reads a URDF file, or a text that begins with ``<``.

        Parameters
        ----------
        path_or_text : str or os.PathLike
        mimic : {"refuse", "independent"}
            The treatment of mimic joints.
        root : str, optional
            The link that becomes the root of the robot, such as the foot on which it stands; by default that of the
            file.
        losses : bool or Mapping
            True to count the damping and the friction in the URDF, or numbers in place of those, as in a scenario:
            ``{"damping": 0.5, "friction": {"joint_1": 2.0}, "friction_velocity": 0.02, "armature": 0.1}``, each of
            which is optional, for all joints or by their names.
        packages : Mapping, optional
            The folders of packages by their names, for meshes ``package://NAME/PATH``.

        Raises
        ------
        InputError
            Names the file, the element and the fault.
        """
        folders = {name: os.path.abspath(folder) for name, folder in (packages or {}).items()}
        options = (mimic, root, text(losses), folders)
        given = os.fspath(path_or_text)
        if given.lstrip().startswith("<"):
            return cls._made("parse", given, "URDF", options)
        own = _aghf.Model.load_file(given, options)
        return cls(own, (cls._made, ("load_file", os.path.abspath(given), options)))

    @classmethod
    def builtin(cls, name: str) -> Model:
        """The built-in robot of this name; `builtin_robots` lists them."""
        return cls._made("builtin", name)

    @classmethod
    def from_pinocchio(cls, model: Any) -> Model:
        """The robot of a ``pinocchio.Model``, with the same order of joints, the same frames and the same gravity.

        Torques of both models are compared at random states. `aghf.pinocchio_configuration` returns Pinocchio's ``q``,
        in which an unbounded revolute joint has a cosine and a sine.

        Parameters
        ----------
        model : pinocchio.Model
            A model of revolute and prismatic joints with any axes, on a fixed base.

        Returns
        -------
        Model

        Raises
        ------
        InputError
            Names the joint and its unsupported feature: more than one degree of freedom, mimic, or an armature; or
            a body without inertia.
        ImportError
            Pinocchio is not installed.
        """
        from ._pinocchio import from_pinocchio

        return from_pinocchio(model)

    @property
    def name(self) -> str:
        return self._own.name

    @property
    def dof(self) -> int:
        return self._own.dof

    @property
    def mass(self) -> float:
        return self._own.mass

    @property
    def joint_names(self) -> list[str]:
        return self._own.joint_names

    @property
    def joint_kinds(self) -> list[str]:
        return self._own.joint_kinds

    @property
    def frame_names(self) -> list[str]:
        return self._own.frame_names

    @property
    def parents(self) -> np.ndarray:
        return self._own.parents

    @property
    def lower(self) -> np.ndarray:
        return self._own.lower

    @property
    def upper(self) -> np.ndarray:
        return self._own.upper

    @property
    def velocity_limits(self) -> np.ndarray:
        return self._own.velocity_limits

    @property
    def effort_limits(self) -> np.ndarray:
        return self._own.effort_limits

    @property
    def gravity(self) -> np.ndarray:
        return self._own.gravity

    @property
    def notes(self) -> list[str]:
        return self._own.notes

    def to_urdf(self) -> str:
        """The robot as URDF, fixed joints merged."""
        return self._own.to_urdf()

    def __repr__(self) -> str:
        return repr(self._own)


def array(x: ArrayLike, name: str) -> np.ndarray:
    """An argument as a contiguous array of float64, without a copy if it is one."""
    try:
        return np.asarray(x, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from None
