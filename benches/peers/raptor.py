#!/usr/bin/env python3
"""A step of Digit from a hundred random starts, beside RAPTOR's: robustness of the search, and a judge of its own.

    pip install pin numpy scipy
    cargo build --release
    python3 benches/peers/raptor.py --starts 100

The step is that of RAPTOR's examples (github.com/roahmlab/RAPTOR, `Examples/Digit`, `DigitSingleStepSpeedTest.cpp` and
`DigitConstants.h`): 0.4 s; the foot that swings begins 0.4 m behind the other one and lands 0.4 m before it, at the
side by 0.22 m; it is flat, never below the ground, and 0.3 m above it halfway; the torso stays within 3 degrees of
upright; friction and torsion of 0.7, a sole of 23.5 by 8 cm; torque limits of hips and knees; the next step is the
mirror image. A start is off by up to 0.1 rad in each joint, and by as much per duration in each velocity.

Differences: RAPTOR closes the loops of Digit's rods by elimination, and its foot may land with a speed that the
ground takes away; here the legs are trees with a motor at the tarsus, the foot lands at rest, and the cost is the
integral of squared torques, so costs are not compared. The robot is made from the pinned one in `robots`, of which the
standing leg has inertias in the frames of the hanging one: the torso and its right leg, with a left leg that is the
mirror image.

The judge knows nothing of ours: the torso is a free-flying base in Pinocchio, whose motion follows from that of the
joints and the foot that stands; the residual of its dynamics is the force of the ground. It checks 2001 times.
"""

import argparse
import copy
import json
import re
import resource
import statistics
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

ROOT = Path(__file__).parents[2]
PINNED = ROOT / "robots/digit_v3_pinned/digit_v3_pinned.urdf"

# DigitConstants.h and DigitSingleStepSpeedTest.cpp of RAPTOR. Rods move the toes, and the tarsus has no motor.
TORQUES = {"hip_roll": 113.0, "hip_yaw": 79.1765, "hip_pitch": 216.928, "knee": 231.317}
FRICTION, TORSION, HALF_LENGTH, HALF_WIDTH = 0.7, 0.7, 0.1175, 0.04
DURATION, STEP, APART, APEX, UPRIGHT = 0.4, 0.4, 0.22, 0.3, np.deg2rad(3.0)
# The foot is flat in RAPTOR; here within this angle.
FLAT = 0.02
# Supplement of RAPTOR, Table I, degree 5, ma57, monotone barrier: seconds, violations.
TABLE = {"median_s": 2.77, "worst_s": 35.6, "median_violation": 5.5e-6, "worst_violation": 1.3e4}


def numbers(text):
    return [float(x) for x in text.split()]


def mirrored(element):
    """The left twin of an element of the right leg, mirrored in the plane of `x` and `z`."""
    twin = copy.deepcopy(element)
    for part in twin.iter():
        for key in ("name", "link"):
            if part.get(key):
                part.set(key, part.get(key).replace("right_", "left_"))
        for key, signs in (("xyz", (1, -1, 1)), ("rpy", (-1, 1, -1))):
            if part.tag == "axis":
                # A rotation is reversed by a reflection.
                signs = (-1, 1, -1)
            if part.get(key):
                part.set(key, " ".join(repr(s * x) for s, x in zip(signs, numbers(part.get(key)))))
        if part.tag == "inertia":
            for key in ("ixy", "iyz"):
                part.set(key, repr(-float(part.get(key))))
    return twin


def digit():
    """Digit with its torso as the root and legs that are mirror images, without arms."""
    pinned = ET.parse(PINNED).getroot()
    robot = ET.Element("robot", name="digit")
    is_leg = lambda name: name.startswith("right_") and not re.search("shoulder|elbow", name)
    for link in pinned.findall("link"):
        if link.get("name") == "torso":
            robot.append(link)
        elif is_leg(link.get("name")):
            robot.extend([link, mirrored(link)])
    for joint in pinned.findall("joint"):
        if not is_leg(joint.find("child").get("link")):
            continue
        if joint.find("parent").get("link") == "torso_virtual":
            joint.find("parent").set("link", "torso")
        limit = joint.find("limit")
        if limit is not None:
            names = (value for key, value in TORQUES.items() if joint.get("name").endswith(key))
            limit.set("effort", repr(next(names, 0.0)))
            limit.set("velocity", "0")
        robot.extend([joint, mirrored(joint)])
    return ET.tostring(robot, encoding="unicode")


def posture(urdf):
    """The joints by name, upright between the feet, with the right foot behind: the first guess of the start."""
    model = pin.buildModelFromUrdf(str(urdf))
    data = model.createData()
    frames = [model.getFrameId(name, pin.FrameType.BODY) for name in ("left_sole", "right_sole")]
    low, high = model.lowerPositionLimit + 0.005, model.upperPositionLimit - 0.005
    behind = np.array([-STEP, -APART, 0.0])

    def off(q, weight):
        pin.framesForwardKinematics(model, data, q)
        left, right = (data.oMf[frame] for frame in frames)
        between = left.actInv(right)
        torso = left.inverse().translation - np.array([-STEP / 2, -APART / 2, 0.9])
        return np.concatenate([between.translation - behind, pin.log3(between.rotation), pin.log3(left.rotation),
                               0.1 * torso, weight * q])

    q = np.zeros(model.nq)
    for weight in (1e-1, 1e-2, 1e-3, 1e-4):
        q = least_squares(off, np.clip(q, low, high), args=(weight,), bounds=(low, high)).x
    return {name: q[model.joints[model.getJointId(name)].idx_q] for name in list(model.names)[1:]}


def scenario(urdf, joints, guess, rng):
    """The step from a random start."""
    stand = {"frame": "left_sole", "half_length_m": HALF_LENGTH, "half_width_m": HALF_WIDTH, "friction": FRICTION,
             "torsion": TORSION}
    upright = {"orientation_xyzw": [0.0, 0.0, 0.0, 1.0]}
    above = {"size_m": [None, None, 2.0], "pose": {"position_m": [0.0, 0.0, 1.0]}}
    return {
        "robot": str(urdf),
        "horizon_s": DURATION,
        "q_start": [guess[joint] + rng.uniform(-0.1, 0.1) for joint in joints],
        "v_start": [rng.uniform(-0.1, 0.1) / DURATION for _ in joints],
        "periodic": True,
        "phases": [{
            "stand": stand,
            "land": {"frame": "right_sole", "position_m": [STEP, -APART, 0.0], **upright},
            "lift_m": APEX,
            "keep": [
                {"frame": "right_sole", "box": above},
                {"frame": "right_sole", **upright, "tolerance_rad": FLAT},
                {"frame": "torso", **upright, "tolerance_rad": UPRIGHT},
            ],
        }],
        "enforced_limits": {"position": True, "velocity": False, "torque": True},
    }


class Judge:
    """Digit with a free base in Pinocchio."""

    def __init__(self, urdf):
        self.model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
        self.data = self.model.createData()
        frame = lambda name: self.model.getFrameId(name, pin.FrameType.BODY)
        self.left, self.right, self.torso = frame("left_sole"), frame("right_sole"), frame("torso")

    def at(self, names, q, v, a):
        """The poses of foot and torso, the velocity of the foot, and violations of the foot that stands."""
        model, data = self.model, self.data
        full = pin.neutral(model)
        rates, bends = np.zeros(model.nv), np.zeros(model.nv)
        for name, *values in zip(names, q, v, a):
            joint = model.joints[model.getJointId(name)]
            full[joint.idx_q], rates[joint.idx_v], bends[joint.idx_v] = values
        pin.framesForwardKinematics(model, data, full)
        full[:7] = pin.SE3ToXYZQUAT(data.oMf[self.left].inverse())
        jacobian = pin.computeFrameJacobian(model, data, full, self.left, pin.LOCAL)
        base = jacobian[:, :6]
        rates[:6] = -np.linalg.solve(base, jacobian[:, 6:] @ rates[6:])
        pin.forwardKinematics(model, data, full, rates, bends)
        drift = pin.getFrameAcceleration(model, data, self.left, pin.LOCAL).vector
        bends[:6] = -np.linalg.solve(base, drift)
        torques = pin.rnea(model, data, full, rates, bends)
        force = np.linalg.solve(base.T, torques[:6])
        own = torques[6:] - jacobian[:, 6:].T @ force
        pin.forwardKinematics(model, data, full, rates)
        pin.updateFramePlacements(model, data)
        speed = pin.getFrameVelocity(model, data, self.right, pin.LOCAL).vector
        order = [model.joints[model.getJointId(name)].idx_v - 6 for name in names]
        (fx, fy, fz), (mx, my, mz) = force[:3], force[3:]
        rows = {
            "normal force": -fz,
            "friction": np.hypot(fx, fy) - FRICTION * fz,
            "torsion": abs(mz) - TORSION * fz,
            "edges along": abs(my) - HALF_LENGTH * fz,
            "edges across": abs(mx) - HALF_WIDTH * fz,
        }
        return data.oMf[self.right].copy(), data.oMf[self.torso].copy(), speed, rows, own[order]

    def violations(self, run):
        """The largest violation of each condition along a motion, N, N m, m, rad and their rates."""
        names, times, columns = read(run / "trajectory.csv")
        q, v, a, u = (columns[part] for part in "qvau")
        degree = json.loads((run / "summary.json").read_text())["degree"]
        fit = [np.polynomial.Chebyshev.fit(times, column, degree) for column in q.T]
        worst = {"fit": max(np.abs(f(times) - column).max() for f, column in zip(fit, q.T))}
        note = lambda row, by: worst.__setitem__(row, max(worst.get(row, 0.0), float(by)))
        dense = np.linspace(0.0, DURATION, 2001)
        values = [np.array([f.deriv(d)(dense) for f in fit]).T for d in (1, 2)]
        low, high, most = (self.limits(names, kind) for kind in ("lower", "upper", "effort"))
        ends = []
        for k, time in enumerate(dense):
            here = np.array([f(time) for f in fit])
            foot, torso, speed, rows, torques = self.at(names, here, values[0][k], values[1][k])
            for row, by in rows.items():
                note(row, by)
            note("positions", max((low - here).max(), (here - high).max()))
            note("torques", (np.abs(torques) - most)[most > 0.0].max())
            note("ground", -foot.translation[2])
            note("flat", np.linalg.norm(pin.log3(foot.rotation)) - FLAT)
            note("upright", np.linalg.norm(pin.log3(torso.rotation)) - UPRIGHT)
            if k in (0, 1000, 2000):
                ends.append((foot, torso, speed, here, values[0][k]))
        note("apex", APEX - ends[1][0].translation[2])
        for (foot, _, speed, *_), along in ((ends[0], -STEP), (ends[2], STEP)):
            note("landing", np.abs(foot.translation - [along, -APART, 0.0]).max())
            note("landing", np.linalg.norm(pin.log3(foot.rotation)))
            note("landing speed", np.abs(speed).max())
        twin = [names.index(swap(name)) for name in names]
        for part in (3, 4):
            # The legs are mirror images, each with positive angles where its twin has them.
            note("mirrored", np.abs(ends[2][part] - ends[0][part][twin]).max())
        _, _, _, _, torques = self.at(names, q[100], v[100], a[100])
        note("torques of the table", np.abs(torques - u[100]).max())
        return worst

    def limits(self, names, kind):
        model = self.model
        joints = [model.joints[model.getJointId(name)] for name in names]
        if kind == "effort":
            return np.array([model.effortLimit[joint.idx_v] for joint in joints])
        all_limits = model.lowerPositionLimit if kind == "lower" else model.upperPositionLimit
        return np.array([all_limits[joint.idx_q] for joint in joints])


def swap(name):
    side, rest = name.split("_", 1)
    return f"{'left' if side == 'right' else 'right'}_{rest}"


def read(path):
    """The names of the joints, the times, and positions, velocities, accelerations and torques of a table."""
    header, *rows = path.read_text().splitlines()
    titles = header.split(",")
    table = np.array([numbers(row.replace(",", " ")) for row in rows])
    names = [title[2:] for title in titles if title.startswith("q_")]
    columns = {part: table[:, [titles.index(f"{part}_{name}") for name in names]] for part in "qvau"}
    return names, table[:, 0], columns


def used():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=100, help="the number of random starts")
    parser.add_argument("--seed", type=int, default=0, help="the seed of the first one")
    parser.add_argument("--aghf", type=Path, default=ROOT / "target/release/aghf", help="the program")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        urdf, standing = folder / "digit.urdf", folder / "left.urdf"
        urdf.write_text(digit())
        run = lambda *words: subprocess.run([arguments.aghf, *words], check=True, capture_output=True, text=True)
        described = run("robots", urdf, "--root", "left_sole", "--json").stdout
        run("robots", urdf, "--root", "left_sole", "--urdf", standing)
        joints = [joint["name"] for joint in json.loads(described)[0]["joints"]]
        guess, judge = posture(urdf), Judge(urdf)
        found = []
        for k in range(arguments.starts):
            rng = np.random.default_rng(arguments.seed + k)
            file, out = folder / f"step_{k}.json", folder / f"out_{k}"
            file.write_text(json.dumps(scenario(urdf, joints, guess, rng)))
            before = used()
            ended = subprocess.run([arguments.aghf, "solve", file, "--threads", "1", "--json", "--no-report", "--out",
                                    out], capture_output=True, text=True)
            cpu = used() - before
            summary = json.loads(ended.stdout)["phases"][0] if ended.stdout else {"verdict": ended.stderr.strip()}
            worst = judge.violations(out / "phase_1") if summary.get("success") else {}
            found.append({"cpu": cpu, "worst": worst, **{key: summary.get(key) for key in
                         ("verdict", "control_effort", "iterations", "solve_seconds")}})
    report(found)


def report(found):
    valid = [one for one in found if one["worst"]]
    rows = sorted({row for one in valid for row in one["worst"]})
    print(f"{len(found)} starts: {sum(one['verdict'] == 'optimal' for one in found)} optimal, {len(valid)} valid")
    if not valid:
        return
    times = [one["cpu"] for one in valid]
    costs = sorted(one["control_effort"] for one in valid)
    print(f"processor time, with loading: median {statistics.median(times):.2f} s, largest {max(times):.2f} s"
          f" (RAPTOR, another machine: {TABLE['median_s']} and {TABLE['worst_s']} s)")
    print(f"iterations: median {statistics.median(one['iterations'] for one in valid):.0f}")
    near = sum(cost <= 1.05 * costs[0] for cost in costs)
    print(f"cost: {costs[0]:.1f} to {costs[-1]:.1f}, {near} within 5 % of the best")
    print("largest violations by the judge, of the median and of the worst start")
    print(f"(RAPTOR: {TABLE['median_violation']:.1e} and {TABLE['worst_violation']:.1e})")
    for row in rows:
        off = sorted(one["worst"][row] for one in valid)
        print(f"  {row:22} {off[len(off) // 2]:9.1e} {off[-1]:9.1e}")


if __name__ == "__main__":
    main()
