"""Direct transcription with IPOPT by CasADi, beside ours: free, within all limits, among spheres."""

import numpy as np
import pinocchio as pin

from common import Motion, Row, add_ours, check_dynamics, finish, percentile, robot, scenario
from expressions import Expressions
import transcription
from transcription import Polynomial, Shooting

SECTION = "ipopt"
NOTE = (
    "IPOPT 3.14 with MUMPS by CasADi, exact first and second derivatives in compiled C (compile times are not "
    'in the times), tolerance 1e-6, from the cubic between the ends. "Degree 16" is the transcription that '
    'ours has: one polynomial for each joint, 60 points; "multiple shooting" has 40 intervals with linear '
    "accelerations, so more unknowns and lower minima. Limits and distances are kept at the points only, so 1 "
    "% of velocities and torques and 1 cm are left for what is between. Ours: the defaults (32 starts for "
    "free motions, one within limits), and one start from the same cubic. Limits: the cost has 0.1 of squared "
    "accelerations, the effort is without."
)
NAMES = lambda pattern, numbers: [pattern.format(number) for number in numbers]
FAMILIES = {
    "pendulums": NAMES("pendulum_{}_swingup", range(1, 7)),
    "Kinova, free": NAMES("kinova_free_{:02}", range(1, 6)),
    "Kinova, all limits": NAMES("limits_{:02}", range(1, 11)),
    "Kinova, spheres": NAMES("kinova_obstacles_{:02}", range(1, 6)),
    "Digit, free": ["digit_free_stretch", "digit_free_step"],
    "Digit, spheres": ["digit_obstacles_2", "digit_obstacles_4"],
}
QUICK = {"pendulums": 2, "Kinova, free": 3, "Kinova, all limits": 3}
# Solves that take more seconds are not repeated.
LONG = 5.0
KINDS = {"IPOPT, degree 16": (Polynomial, {}), "IPOPT, multiple shooting": (Shooting, {})}
OURS = {"ours, one start": ["--starts", "1"], "ours": [], "ours, degree 32": ["--degree", "32"]}


def motion_of(programme, values, x):
    """The motion at 2001 times, torques by Pinocchio."""
    model = programme.expressions.model
    times = np.linspace(0, values["horizon_s"], 2001)
    q, v, a = programme.sampled(values, x, times)
    data = model.createData()
    u = np.array([pin.rnea(model, data, *sample) for sample in zip(q, v, a)])
    return Motion(times, q, v, a, u, names=list(model.names)[1:])


def solve(table, family, names, kind, repeats):
    """Rows of one transcription for a family, whose scenarios have the same robot and the same kinds of rows."""
    built = {}
    for name in names:
        if table.has(SECTION, name, kind):
            continue
        values = scenario(name)
        limits = tuple(key for key, enforced in values["enforced_limits"].items() if enforced)
        spheres = sum("sphere" in obstacle["shape"] for obstacle in values.get("obstacles", []))
        key = (values["robot"], limits, spheres)
        if key not in built:
            model = robot(values["robot"])
            check_dynamics(model, values["robot"])
            weight = values.get("objective", {}).get("acceleration", 0.0)
            kept = {"limits": limits, "spheres": spheres, "acceleration": weight}
            built[key] = KINDS[kind][0](Expressions(model), **KINDS[kind][1], **kept)
        programme = built[key]
        runs = [programme.solve(values)]
        runs += [programme.solve(values) for _ in range(repeats - 1) if runs[0][1] < LONG]
        stats, _, x = runs[0]
        row = Row(SECTION, family, name, kind, repeats=len(runs), iterations=stats["iter_count"])
        row.seconds, row.seconds_90 = (percentile([run[1] for run in runs], share) for share in (0.5, 0.9))
        if not stats["success"]:
            row.note = stats["return_status"]
        if programme.compile_seconds:
            row.note = "; ".join(filter(None, [row.note, f"compiled in {programme.compile_seconds:.0f} s"]))
        finish(row, values, motion_of(programme, values, x))
        row.success = row.success and bool(stats["success"])
        table.add(row)


def run(table, options):
    """All families, or the first scenarios of some of them for a quick run; ours before and after each peer."""
    if options.quick:
        # A fifth slower, compiled in half of the time.
        transcription.FLAGS = transcription.LARGE
    for family, names in FAMILIES.items():
        if options.quick:
            names = names[: QUICK.get(family, 0)]
        for name in names:
            for method, extra in OURS.items():
                add_ours(table, SECTION, family, scenario(name), method, extra, options.repeats)
        for kind in KINDS:
            solve(table, family, names, kind, options.repeats)
