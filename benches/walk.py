"""Walks of humanoids: writes the scenario of a walk of Digit, Talos or G1, to be solved by `aghf solve`.

    python benches/walk.py talos --steps 10 --out walk_talos.json

Needs Python packages alone: `pin`, `scipy` and, for the robots but Digit, `example-robot-data`. The robot begins at
rest on its left foot, with the weight above it and the right foot beside it on the ground, and ends with both feet
side by side after the last step.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sysconfig

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

HERE = pathlib.Path(__file__).resolve().parent
DIGIT = HERE.parent / "robots/digit_v3_pinned/digit_v3_pinned.urdf"

# The soles, half of their lengths and widths, the distance of the feet, the joints that walk, and the bend of the
# knees from which the first posture is looked for. Half sizes are estimates but that of Digit, which is that of the
# scenarios in robots/digit_v3_pinned.
ROBOTS = {
    "talos": {
        "urdf": ("talos_data", "talos_reduced.urdf"),
        "feet": ("left_sole_link", "right_sole_link"),
        "half": (0.1, 0.06),
        "apart": 0.17,
        "legs": ("leg_",),
        "bend": {"_3_joint": -0.4, "_4_joint": 0.8, "_5_joint": -0.4},
        "arms": {"arm_left_2_joint": 0.3, "arm_right_2_joint": -0.3,
                 "arm_left_4_joint": -1.0, "arm_right_4_joint": -1.0},
        "torque": True,
    },
    "g1": {
        "urdf": ("g1_description", "g1_29dof_rev_1_0.urdf"),
        "feet": ("left_ankle_roll_link", "right_ankle_roll_link"),
        "half": (0.085, 0.03),
        "sole": (0.035, 0.0, -0.03),
        "apart": 0.2,
        "legs": ("_hip_", "_knee_", "_ankle_"),
        "bend": {"_hip_pitch_joint": -0.3, "_knee_joint": 0.6, "_ankle_pitch_joint": -0.3},
        "arms": {},
        "torque": True,
    },
    "digit": {
        "urdf": None,
        "feet": ("left_toe_roll", "right_sole"),
        "half": (0.1175, 0.04),
        "apart": 0.25,
        "legs": ("_hip_", "_knee", "_tarsus", "_toe_"),
        "bend": {},
        "arms": {},
        "torque": False,
    },
}


def source(robot):
    """The URDF of a robot."""
    if ROBOTS[robot]["urdf"] is None:
        return DIGIT
    folder, name = ROBOTS[robot]["urdf"]
    robots = pathlib.Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
    found = sorted((robots / folder).rglob(name))
    if not found:
        raise SystemExit(f"{robots / folder}: it has no {name}; pip install example-robot-data")
    return found[0]


class Robot:
    """A robot on its left foot, of which the legs move."""

    def __init__(self, name, aghf, folder):
        self.spec = ROBOTS[name]
        self.urdf = source(name)
        left = folder / f"{name}_left.urdf"
        root = ["--root", self.spec["feet"][0]]
        run = lambda *more: subprocess.run([aghf, "robots", self.urdf, *root, *more], check=True, capture_output=True)
        run("--urdf", left, "--force")
        joints = [joint["name"] for joint in json.loads(run("--json").stdout)[0]["joints"]]
        self.model = pin.buildModelFromUrdf(str(left))
        self.data = self.model.createData()
        self.other = self.model.getFrameId(self.spec["feet"][1], pin.FrameType.BODY)
        self.low, self.high = self.model.lowerPositionLimit, self.model.upperPositionLimit
        index = lambda joint: self.model.joints[self.model.getJointId(joint)].idx_q
        walks = lambda joint: any(part in joint for part in self.spec["legs"])
        self.legs = {joint: index(joint) for joint in joints if walks(joint)}
        self.held = pin.neutral(self.model)
        self.locked = {}
        for joint in joints:
            if joint not in self.legs:
                at = index(joint)
                position = self.spec["arms"].get(joint, 0.0)
                self.locked[joint] = float(np.clip(position, self.low[at], self.high[at]))
                self.held[at] = self.locked[joint]

    def centre(self):
        """The centre of mass with that of the foot that stands, at the last posture."""
        parts = [(inertia.mass, self.data.oMi[i].act(inertia.lever)) for i, inertia in enumerate(self.model.inertias)]
        return sum(mass * at for mass, at in parts) / sum(mass for mass, _ in parts)

    def posture(self):
        """The legs with the right foot beside the left one, and the weight above that, near bent knees."""
        at = np.array(list(self.legs.values()))
        bends = self.spec["bend"].items()
        seed = np.array([next((q for part, q in bends if leg.endswith(part)), 0.0) for leg in self.legs])
        low, high = self.low[at], self.high[at]
        inner = (low + 0.005 * (high - low), high - 0.005 * (high - low))
        beside = np.array([0.0, -self.spec["apart"], 0.0])
        above = np.array([self.spec.get("sole", (0.0,))[0], -0.2 * self.spec["half"][1]])

        def off(legs, weight):
            q = self.held.copy()
            q[at] = legs
            pin.framesForwardKinematics(self.model, self.data, q)
            foot = self.data.oMf[self.other]
            rows = [foot.translation - beside, pin.log3(foot.rotation), self.centre()[:2] - above]
            return np.concatenate([*rows, weight * (legs - seed)])

        legs = np.clip(seed, *inner)
        for weight in (1e-2, 1e-3, 1e-5):
            legs = least_squares(off, legs, args=(weight,), bounds=inner, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
            legs = np.clip(legs, *inner)
        worst = np.abs(off(legs, 0.0)[:8]).max()
        if worst > 1e-5:
            raise SystemExit(f"no posture on the left foot was found, the best one is off by {worst:.2e}")
        return legs


def scenario(robot, arguments):
    """The scenario of a walk."""
    spec, steps = robot.spec, arguments.steps
    q = robot.posture()
    phases = []
    for k in range(steps):
        stand, land = (spec["feet"][i] for i in ((0, 1) if k % 2 == 0 else (1, 0)))
        side = -spec["apart"] if k % 2 == 0 else spec["apart"]
        forward = arguments.step if k + 1 < steps else 0.0
        foot = {"frame": stand, "half_length_m": spec["half"][0], "half_width_m": spec["half"][1], "friction": 0.7}
        if "sole" in spec:
            foot["sole"] = {"position_m": spec["sole"]}
        pose = {"position_m": [forward, side, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 1.0]}
        # The foot lands within 1e-6 m of the ground, which a certificate of a bound at the ground would not accept.
        above = {"size_m": [None, None, 1.000002], "pose": {"position_m": [0.0, 0.0, 0.5]}}
        phase = {"stand": foot, "land": {"frame": land, **pose}, "keep": [{"frame": land, "box": above}]}
        if arguments.lift > 0.0:
            phase["lift_m"] = arguments.lift
        phases.append(phase)
    return {
        "robot": str(robot.urdf),
        "locked_joints": robot.locked,
        "robot_shape": "joint_frames",
        "horizon_s": arguments.time * steps,
        "q_start": q.tolist(),
        "v_start": [0.0] * len(q),
        "phases": phases,
        "enforced_limits": {"position": True, "velocity": True, "torque": spec["torque"]},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot", choices=ROBOTS)
    parser.add_argument("--steps", type=int, default=10, help="the number of phases")
    parser.add_argument("--step", type=float, default=0.2, help="the length of a step, m")
    parser.add_argument("--lift", type=float, default=0.05, help="the height of the foot halfway, m")
    parser.add_argument("--time", type=float, default=0.8, help="the duration of a step, s")
    parser.add_argument("--aghf", default="target/release/aghf", help="the program")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the file of the scenario")
    arguments = parser.parse_args()
    if not (arguments.steps >= 1 and math.isfinite(arguments.time) and arguments.time > 0.0):
        parser.error("steps and their duration are positive")
    robot = Robot(arguments.robot, arguments.aghf, arguments.out.resolve().parent)
    arguments.out.write_text(json.dumps(scenario(robot, arguments), indent=1) + "\n")


if __name__ == "__main__":
    main()
