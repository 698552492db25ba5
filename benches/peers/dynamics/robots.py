"""Writes the robots of the comparison, each as a URDF and as numbers, and random states of each.

    python robots.py REPOSITORY FOLDER

ROBOT.txt holds the numbers of joints and states; per joint its parent (0 is the base), kind, axis, placement in the
parent (rotation row by row, translation) and the mass, centre and inertia about the centre of its body, as Pinocchio
reads them from the URDF; per state positions, velocities, accelerations and forces.
"""

import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pinocchio as pin

STATES = 64


def chain(joints: int) -> str:
    """The URDF of an arm: axes y, z, x in turn, links of 0.3 m that twist."""
    rng = np.random.default_rng(joints)
    text = [f'<robot name="chain_{joints}"><link name="link_0"/>']
    for i in range(1, joints + 1):
        axis = ["0 1 0", "0 0 1", "1 0 0"][i % 3]
        mass = 3.0 / i**0.5
        rpy = " ".join(f"{x:.3f}" for x in rng.uniform(-1.5, 1.5, 3))
        com = " ".join(f"{x:.3f}" for x in rng.uniform(-0.1, 0.1, 3))
        text.append(
            f'<link name="link_{i}"><inertial><origin xyz="{com}" rpy="0 0 0"/><mass value="{mass:.3f}"/>'
            f'<inertia ixx="{0.02 * mass:.5f}" ixy="0.001" ixz="0.0005" iyy="{0.015 * mass:.5f}" iyz="0.0002"'
            f' izz="{0.01 * mass:.5f}"/></inertial></link>'
            f'<joint name="joint_{i:02}" type="revolute"><parent link="link_{i - 1}"/><child link="link_{i}"/>'
            f'<origin xyz="0 0.05 0.3" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="-3" upper="3" velocity="3" effort="100"/></joint>'
        )
    return "\n".join([*text, "</robot>\n"])


def kind(joint) -> tuple[str, np.ndarray]:
    """The kind of a joint of Pinocchio and its axis.

    Continuous joints, whose position is a cosine and a sine in Pinocchio, become revolute ones: everyone gets the
    same angles and takes the sines and cosines of all of them.
    """
    name = joint.shortname().removeprefix("JointModel")
    kinds = {"RUB": "revolute", "RevoluteUnbounded": "revolute", "R": "revolute", "Revolute": "revolute"}
    kinds |= {"P": "prismatic", "Prismatic": "prismatic"}
    for start, which in kinds.items():
        for k, letter in enumerate("XYZ"):
            if name == start + letter:
                return which, np.eye(3)[k]
        if name == start + "Unaligned":
            return which, joint.extract().axis
    raise SystemExit(f"robots.py: no counterpart of {name}")


def row(values) -> str:
    """Numbers in a line, in all their digits."""
    return " ".join(repr(float(x)) for x in np.ravel(values))


def joints(model: pin.Model) -> list[str]:
    """The lines of the joints."""
    text = []
    for i in range(1, model.njoints):
        which, axis = kind(model.joints[i])
        placement, body = model.jointPlacements[i], model.inertias[i]
        text.append(f"{model.parents[i]} {which} {row(axis)}")
        text.append(f"{row(placement.rotation)} {row(placement.translation)}")
        text.append(f"{row(body.mass)} {row(body.lever)} {row(body.inertia)}")
    return text


def numbers(model: pin.Model) -> str:
    """The file of a robot."""
    text = [f"{model.njoints - 1} {STATES}", *joints(model)]
    rng = np.random.default_rng(1)
    for _ in range(STATES):
        text += [row(rng.uniform(-1, 1, model.nv) * scale) for scale in (1.5, 1.0, 2.0, 10.0)]
    return "\n".join(text) + "\n"


def main() -> None:
    repository, folder = map(Path, sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    shared = next(Path(pin.__file__).parents[4].rglob("icub_description/robots/icub.urdf"), None)
    files = {
        "kinova": repository / "robots/kinova_gen3/kinova_gen3.urdf",
        "digit": repository / "robots/digit_v3_pinned/digit_v3_pinned.urdf",
        "icub": shared,
    }
    for joints in (7, 22):
        (folder / f"chain_{joints}.urdf").write_text(chain(joints))
    for name, path in files.items():
        if path is None:
            raise SystemExit(f"robots.py: the wheel of example-robot-data holds no {name}")
        text = xml.parse(path)
        # Shapes have no part in the dynamics, and not every reader takes those of every robot.
        for link in text.getroot().iter("link"):
            for shape in link.findall("visual") + link.findall("collision"):
                link.remove(shape)
        text.write(folder / f"{name}.urdf")
    for path in sorted(folder.glob("*.urdf")):
        model = pin.buildModelFromUrdf(str(path))
        path.with_suffix(".txt").write_text(numbers(model))


if __name__ == "__main__":
    main()
