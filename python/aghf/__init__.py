"""Trajectory optimisation with the Affine Geometric Heat Flow, and rigid-body dynamics with exact derivatives.

Arrays are of float64. Functions of states take one state, shape ``(N,)``, or a batch, shape ``(B, N)``, and their
results have the same leading dimension; large batches use all cores. Units: m, rad, s, kg, N, N m.
"""

from ._dynamics import (
    aba,
    aba_derivatives,
    aba_second_derivatives,
    crba,
    energy,
    forward_kinematics,
    frame_jacobian,
    frame_placement,
    inverse_kinematics,
    mass_matrix_and_rate,
    omega,
    omega_jacobian,
    rnea,
    rnea_derivatives,
    rnea_second_derivatives,
    rnea_vjp,
    rnea_weighted_hessian,
)
from ._goal import Goal
from ._judge import Clearance, clearance, judge
from ._many import solve_each, solve_many
from ._model import Model
from ._native import _aghf
from ._nlp import Program, ProgramSolution, solve_nlp
from ._pinocchio import pinocchio_configuration
from ._solution import stack
from ._solve import InputError, Samples, Solution, Tradeoff, solve, sweep, tradeoff
from ._table import Table
from ._tracker import Command, Step, Tracker, Violation
from ._verify import Constraint, RunningCost, check, check_constraint, check_cost

__version__ = _aghf.__version__
builtin_robots = _aghf.builtin_robots
jacobians = _aghf.jacobians

__all__ = [
    "Clearance",
    "Command",
    "Constraint",
    "Goal",
    "InputError",
    "Model",
    "Program",
    "ProgramSolution",
    "RunningCost",
    "Samples",
    "Solution",
    "Step",
    "Table",
    "Tracker",
    "Tradeoff",
    "Violation",
    "aba",
    "aba_derivatives",
    "aba_second_derivatives",
    "builtin_robots",
    "check",
    "check_constraint",
    "check_cost",
    "clearance",
    "crba",
    "energy",
    "forward_kinematics",
    "frame_jacobian",
    "frame_placement",
    "inverse_kinematics",
    "jacobians",
    "judge",
    "mass_matrix_and_rate",
    "omega",
    "omega_jacobian",
    "pinocchio_configuration",
    "rnea",
    "rnea_derivatives",
    "rnea_second_derivatives",
    "rnea_vjp",
    "rnea_weighted_hessian",
    "solve",
    "solve_each",
    "solve_many",
    "solve_nlp",
    "stack",
    "sweep",
    "tradeoff",
]
