"""MotionBenchMaker for the Panda: VAMP's paths timed by TOPP-RA, beside ours."""

import csv
import json
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
import toppra
from scipy.spatial.transform import Rotation
from toppra import algorithm, constraint

import common
from common import WORK, Motion, Row, aghf, judge, robot
from programs import built

SECTION = "mbm"
NOTE = (
    "The problems of MotionBenchMaker for the Panda as the sources of vamp-planner 0.6.4 have them. VAMP: "
    "RRT-Connect with a Halton sequence and its simplification, the settings of its own `evaluate_mbm.py`, "
    "compiled with its own flags but for nearest neighbours, which go through all nodes as the library it "
    "uses is in no registry. TOPP-RA: the fastest timing of a cubic spline through the path, at 200 points "
    "with its scheme `Interpolation`, within 98 % of the limits of velocity, 90 % of those of torque and, as "
    "the URDF has none, 10 rad/s² of acceleration; with the whole of the limits most motions exceed them "
    'between the points. "Corners" are the path as it is, stopping at each waypoint: it stays where VAMP '
    "proved it free; the spline leaves it. Ours is within the same limits of position, velocity and torque, "
    "without one of acceleration: of least effort in a duration of its own choice, of least effort in at most "
    "1.25 times its least time, and of least time; of every so many of the latter, TOPP-RA times the path anew, with "
    "the whole of the limits at 401 points and jumps of the acceleration, also at rest. Times: planning, "
    "simplification, spline and timing; TOPP-RA's part is Python and C."
)
FAMILIES = [
    "bookshelf_small",
    "bookshelf_tall",
    "bookshelf_thin",
    "box",
    "cage",
    "table_pick",
    "table_under_pick",
]
# The objectives of ours, by the names of their rows.
OURS = {"ours": "least-effort", "ours, balanced": "balanced", "ours, least time": "least-time"}
ACCELERATION = 10.0
# Its recommended way to keep limits between the points of the grid as well.
INTERPOLATION = constraint.DiscretizationType.Interpolation
# The longest timing that is taken for a motion, s: a path that hardly moves at one place can take hours.
LONGEST = 60.0
# One of so many problems is timed anew along our own path, by a spline through so many points.
ANEW, KNOTS = 7, 101
PACKAGE = "vamp_planner-0.6.4"


def sources():
    """The unpacked source package of VAMP with its problems, downloaded once."""
    folder = WORK / PACKAGE
    panda = folder / "resources" / "panda"
    if not (panda / "problems").exists():
        command = [
            sys.executable,
            "-m",
            "pip",
            "download",
            "--quiet",
            "--no-deps",
            "--no-binary",
            "vamp-planner",
            "vamp-planner==0.6.4",
        ]
        subprocess.run([*command, "--dest", WORK], check=True)
        with tarfile.open(WORK / f"{PACKAGE}.tar.gz") as archive:
            archive.extractall(WORK, filter="data")
        with tarfile.open(panda / "problems.tar.bz2") as archive:
            archive.extractall(panda, filter="data")
    return folder


def imported(family, number, panda):
    """A problem as a scenario of ours: its name and file; nothing if there is no such problem."""
    folder = panda / "problems" / f"{family}_panda"
    scene, request = (folder / f"{kind}{number:04}.yaml" for kind in ("scene", "request"))
    name = f"{family}_{number:04}"
    file = WORK / "mbm" / f"{name}.json"
    file.parent.mkdir(exist_ok=True)
    if not scene.exists():
        return None
    if not file.exists():
        aghf("import", "moveit", scene, request, "--urdf", "panda", "--srdf", panda / "panda.srdf", "-o", file)
    return name, file


def words(name, values, box_family):
    """A problem as the words that `plan.cc` reads. Cylinders become capsules, in the family `box` cuboids, as VAMP's
    own script does."""
    boxes, capsules = [], []
    for obstacle in values.get("obstacles", []):
        shape, pose = obstacle["shape"], obstacle["pose"]
        center, turn = pose["position_m"], Rotation.from_quat(pose.get("orientation_xyzw", [0, 0, 0, 1]))
        if "box" in shape:
            boxes.append((center, turn, np.divide(shape["box"]["size_m"], 2)))
            continue
        radius, half_length = shape["cylinder"]["radius_m"], shape["cylinder"]["length_m"] / 2
        if box_family:
            boxes.append((center, turn, [radius, radius, half_length]))
        else:
            axis = turn.apply([0, 0, half_length])
            capsules.append([*np.subtract(center, axis), *np.add(center, axis), radius])
    fields = [name, *values["q_start"], *values["q_goal"], len(boxes)]
    for center, rotation, half in boxes:
        fields += [*center, *rotation.as_euler("xyz"), *half]
    fields.append(len(capsules))
    return " ".join(map(str, fields + [x for capsule in capsules for x in capsule]))


def planned(problems, repeats):
    """VAMP's paths: for each problem the seconds, median and 90th percentile, and the waypoints, none where it found
    no path."""
    program = built("vamp", VAMP_SOURCES=sources())
    lines = [words(name, values, name.startswith("box")) for name, _, values in problems]
    run = subprocess.run([program, str(repeats)], input="\n".join(lines), capture_output=True, text=True, check=True)
    result = {}
    for line in run.stdout.splitlines():
        name, median, share, count, *numbers = line.split()
        waypoints = np.array(numbers, float).reshape(int(count), -1)[:, :7] if int(count) else None
        result[name] = (float(median) * 1e-9, float(share) * 1e-9, waypoints)
    return result


class Timing:
    """TOPP-RA for the Panda within its limits, or the whole of them at the points of the grid."""

    def __init__(self, model, whole=False):
        self.model, self.data = model, model.createData()
        limit = lambda bound: np.stack([-bound, bound], axis=1)
        dynamics = lambda q, v, a: pin.rnea(self.model, self.data, q, v, a)
        velocity, torque = (1.0, 1.0) if whole else (0.98, 0.9)
        scheme = constraint.DiscretizationType.Collocation if whole else INTERPOLATION
        accelerations = limit(np.full(model.nv, ACCELERATION))
        torques = limit(torque * model.effortLimit)
        self.constraints = [
            constraint.JointVelocityConstraint(limit(velocity * model.velocityLimit)),
            constraint.JointTorqueConstraint(dynamics, torques, np.zeros(model.nv), scheme),
        ]
        if not whole:
            self.constraints.append(constraint.JointAccelerationConstraint(accelerations, scheme))

    def __call__(self, path, points=201):
        """The fastest motion along a path from rest to rest, or none."""
        grid = np.linspace(path.path_interval[0], path.path_interval[1], points)
        return algorithm.TOPPRA(self.constraints, path, gridpoints=grid).compute_trajectory(0, 0)


def spline(timing, waypoints):
    """One cubic spline through the waypoints, at arc length, clamped at both ends: pieces of (trajectory,
    beginning)."""
    s = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))]
    return [timing(toppra.SplineInterpolator(s, waypoints, bc_type="clamped"))]


def corners(timing, waypoints):
    """A motion along each straight piece, at rest at each waypoint."""
    return [
        timing(toppra.SplineInterpolator([0.0, 1.0], piece, bc_type="not-a-knot"), 51)
        for piece in zip(waypoints, waypoints[1:])
    ]


def sampled(model, pieces, rate=1000):
    """Pieces of motion one after the other as a table."""
    data, tables, before = model.createData(), [], 0.0
    for piece in pieces:
        times = np.linspace(0, piece.duration, max(int(piece.duration * rate), 20) + 1)
        q, v, a = (piece(times, order) for order in range(3))
        first = 1 if tables else 0
        tables.append([(times + before)[first:], q[first:], v[first:], a[first:]])
        before += piece.duration
    t, q, v, a = (np.concatenate([table[k] for table in tables]) for k in range(4))
    u = np.array([pin.rnea(model, data, *sample) for sample in zip(q, v, a)])
    return Motion(t, q, v, a, u, names=list(model.names)[1:])


def with_horizon(values, duration, folder):
    """The scenario with the duration of a motion, which is the choice of the peer as ours is, and with jumps of the
    acceleration, which TOPP-RA has."""
    changed = {key: value for key, value in values.items() if key not in ("free_horizon", "objective")}
    file = Path(folder) / "scenario.json"
    file.write_text(json.dumps({**changed, "horizon_s": duration, "continuity": "velocity"}))
    return file


def peers(table, problems, repeats):
    """Rows of VAMP and TOPP-RA."""
    from common import timed

    model = robot("panda")
    timing = Timing(model)
    paths = planned(problems, max(repeats, 5))
    for name, family, values in problems:
        plan, plan_90, waypoints = paths[name]
        for method, shape in (("VAMP, TOPP-RA, spline", spline), ("VAMP, TOPP-RA, corners", corners)):
            if table.has(SECTION, name, method):
                continue
            row = Row(SECTION, family, name, method, repeats=repeats, seconds=plan, seconds_90=plan_90)
            if waypoints is None:
                row.note = "no path"
                table.add(row)
                continue
            runs = [timed(shape, timing, waypoints) for _ in range(repeats)]
            seconds = sorted(run[1] for run in runs)
            row.seconds += seconds[len(seconds) // 2]
            row.seconds_90 += seconds[-1]
            pieces = runs[0][0]
            row.note = f"plan {1e3 * plan:.2f} ms, {len(waypoints)} waypoints"
            if any(piece is None for piece in pieces):
                row.note += "; no timing"
                table.add(row)
                continue
            duration = sum(piece.duration for piece in pieces)
            if duration > LONGEST:
                row.note += f"; timing of {duration:.0f} s"
                table.add(row)
                continue
            motion = sampled(model, pieces)
            row.duration, row.effort = float(motion.t[-1]), motion.effort()
            with tempfile.TemporaryDirectory() as folder:
                row.valid, fault = judge(with_horizon(values, row.duration, folder), motion)
            row.success = row.valid
            row.note = "; ".join(filter(None, [row.note, fault]))
            table.add(row)


def ours(table, problems, kind, objective):
    """Rows of `aghf benchmark` on the same problems with an objective."""
    left = [problem for problem in problems if not table.has(SECTION, problem[0], kind)]
    if not left:
        return
    with tempfile.TemporaryDirectory() as folder:
        for name, _, values in left:
            changed = {**values, "robot": "panda", "objective": objective}
            (Path(folder) / f"{name}.json").write_text(json.dumps(changed))
        out = Path(folder) / "out"
        aghf("benchmark", folder, "--out", out)
        with open(out / "results.csv", newline="") as file:
            found = {entry["problem"]: entry for entry in csv.DictReader(file)}
    number = lambda text: float(text) if text else float("nan")
    for name, family, _ in left:
        entry = found[name]
        good = entry["end"] in ("optimal", "valid")
        row = Row(SECTION, family, name, kind, success=good, valid=good, repeats=1, note=entry["reason"])
        row.seconds = row.seconds_90 = number(entry["solve_seconds"])
        row.effort, row.duration = number(entry["control_effort"]), number(entry["duration_s"])
        table.add(row)


def anew(problems):
    """The shares by which motions of least time last longer than TOPP-RA takes along their paths."""
    timing = Timing(robot("panda"), whole=True)
    for _, _, values in problems[::ANEW]:
        file = WORK / "least_time.json"
        file.write_text(json.dumps({**values, "robot": "panda", "objective": "least-time"}))
        summary, _, motion = common.ours({"file": file}, [], 1)
        if not summary["success"]:
            continue
        s = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(motion.q, axis=0), axis=1))]
        at = np.unique(np.searchsorted(s, np.linspace(0, s[-1], KNOTS)))
        timed = timing(toppra.SplineInterpolator(s[at], motion.q[at], bc_type="natural"), 401)
        if timed:
            yield motion.t[-1] / timed.duration - 1


def compared(table, problems):
    """Prints our motions beside those of the peer, where both are valid."""
    rows = {(row.scenario, row.method): row for row in table.rows if row.section == SECTION and row.valid}
    pairs = [(method, "VAMP, TOPP-RA, spline") for method in OURS] + [("ours, balanced", "ours, least time")]
    for method, beside in pairs:
        both = [(row, rows.get((row.scenario, beside))) for row in rows.values() if row.method == method]
        both = [pair for pair in both if pair[1]]
        for what in ("duration", "effort"):
            shares = [getattr(row, what) / getattr(other, what) for row, other in both]
            mean = np.exp(np.mean(np.log(shares))) if shares else np.nan
            median = common.percentile(shares, 0.5)
            print(f"{what}, {method} / {beside}: mean {mean:.3f}, median {median:.3f} of {len(shares)}")
    shares = list(anew(problems))
    summary = ", ".join(f"{100 * common.percentile(shares, share):.2f} % ({share:.0%})" for share in (0.5, 0.95, 1.0))
    print(f"longer than TOPP-RA along the same path, {len(shares)} motions of least time: {summary}")


def run(table, options):
    """All problems of a family, or every so many of them."""
    panda = sources() / "resources" / "panda"
    problems = []
    for family in FAMILIES:
        for number in range(1, 101, 50 if options.quick else options.stride):
            found = imported(family, number, panda)
            if found:
                problems.append((found[0], family, json.loads(found[1].read_text())))
    for kind, objective in OURS.items():
        ours(table, problems, kind, objective)
    peers(table, problems, options.repeats)
    compared(table, problems)
