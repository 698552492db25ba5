"""A checker of certificates, with numpy alone: `python -m aghf.check_certificate ROBOT.urdf SCENARIO SUMMARY
CERTIFICATE`.

It shares no code with the library that plans motions and writes certificates: URDF, scenario, polynomials, inverse
dynamics and distances are read and computed here once more, for all intervals at once, with the errors of rounding.
`proofs/certificate.md` has the statement and its proof. SCENARIO is a scenario or a summary that contains one.
"""

import json
import math
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np

UNIT = 2.0**-53
UP = 1.0 + 1024.0 * UNIT
TINY = 2.0**-1022
SIN_COS = 2.0**-51  # the assumed error of the sine and the cosine of the platform
TOLERANCE, STATE, ACCELERATION = 1e-9, 1e-9, 1e-6
EQUALITY = 1e-6  # the largest deviation of a row that is zero, in its unit
SAME_TIME = 1e-12  # the accepted difference of times, of the horizon: more than rounding
ORDER = 10
GROUP = "; where the scenario has a group or an SRDF, the summary of the motion is to take its place"
KINDS = ["position", "velocity", "acceleration", "jerk", "torque"]


class Refused(Exception):
    """The reason of a refusal."""


def require(condition, fault):
    if not condition:
        raise Refused(fault)


class Model:
    """Functions within `r` of the polynomials with the coefficients `c[0], c[1], ...` in s, from -1 to 1."""

    def __init__(self, c, r):
        self.c, self.r = c, r

    @staticmethod
    def constant(x, radius=0.0, order=ORDER):
        x = np.asarray(x, dtype=float)
        c = np.zeros((order, *x.shape))
        c[0] = x
        return Model(c, np.full(x.shape, float(radius)))

    def like(self, x, radius=0.0):
        return Model.constant(np.broadcast_to(x, self.c.shape[1:]), radius, len(self.c))

    def size(self):
        return np.abs(self.c).sum(axis=0)

    def most(self):
        return (self.size() + self.r) * UP

    def variation(self):
        return (np.abs(self.c[1:]).sum(axis=0) + self.r) * UP

    def widened(self, by):
        return Model(self.c, (self.r + by) * UP + TINY)

    def beside(self, other):
        """The coefficients with as many axes as the other ones need."""
        shape, axes = self.c.shape, max(other.c.ndim - self.c.ndim, 0)
        return self.c.reshape(shape[:1] + (1,) * axes + shape[1:])

    def __add__(self, other):
        c = self.beside(other) + other.beside(self)
        return Model(c, (self.r + other.r + UNIT * np.abs(c).sum(axis=0)) * UP + TINY)

    def __neg__(self):
        return Model(-self.c, self.r)

    def __sub__(self, other):
        return self + -other

    def __mul__(self, b):
        n, own, other = len(self.c), self.beside(b), b.beside(self)
        c = np.zeros((n, *np.broadcast_shapes(own.shape[1:], other.shape[1:])))
        for i in range(n):
            c[i:] += own[i] * other[: n - i]
        size, other = np.abs(own), np.abs(other)
        tail = np.cumsum(other[::-1], axis=0)  # the last one, the last two, ...
        cut = (size[1:] * tail[:-1]).sum(axis=0)
        size, tail = size.sum(axis=0), tail[-1]
        errors = (n + 2) * UNIT * size * tail + size * b.r + self.r * (tail + b.r)
        return Model(c, (cut + errors) * UP + TINY)

    def over(self, x):
        c = self.c / x
        return Model(c, (self.r / np.abs(x) + UNIT * np.abs(c).sum(axis=0)) * UP + TINY)

    def __getitem__(self, key):
        return Model(self.c[(slice(None), *(key if isinstance(key, tuple) else (key,)))], self.r[key])

    def turn(self):
        c = self.c.copy()
        c[0] = 0.0
        return self.c[0], Model(c, self.r)

    def sin_cos(self):
        first, turn = self.turn()
        size = turn.most()
        is_small = (size <= 1.0) & np.isfinite(first)
        square, one = turn * turn, self.like(1.0)

        def nested(odd):
            total = one
            for k in range(8, 0, -1):
                n = 2 * k + odd
                total = one - (square * total).over(float(n * (n - 1)))
            return total

        rest = size**18 / 6e15
        cosine, sine = nested(0).widened(rest), (turn * nested(1)).widened(rest)
        # The functions of numpy may be less accurate than those of the platform.
        finite = np.where(np.isfinite(first), first, 0.0)
        sin = self.like(np.array([math.sin(x) for x in finite.flat]).reshape(first.shape), SIN_COS)
        cos = self.like(np.array([math.cos(x) for x in finite.flat]).reshape(first.shape), SIN_COS)
        found = []
        for value in (sin * cosine + cos * sine, cos * cosine - sin * sine):
            c, r = np.where(is_small, value.c, 0.0), np.where(is_small, value.r, 1.0)
            found.append(Model(c, r))
        return found

    def inverse_sqrt(self):
        first, rest = self.turn()
        is_positive = first > 0.0
        safe = np.where(is_positive, first, 1.0)
        x = rest.over(safe)
        size = x.most()
        is_good = is_positive & (size < 0.99)
        size = np.where(is_good, size, 0.5)
        one = self.like(1.0)
        series = one
        for k in range(16, 0, -1):
            series = one - (x * series * self.like(2.0 * k - 1.0)).over(2.0 * k)
        series = series.widened(1.01 * size**17 / (1.0 - size))
        # The root is rounded, relative to values of the series of at most 10.
        root = np.sqrt(safe)
        found = series.over(root).widened(20.0 * UNIT / root)
        return Model(np.where(is_good, found.c, 0.0), np.where(is_good, found.r, np.inf))


def stack(models):
    shape = np.broadcast_shapes(*(m.r.shape for m in models))
    c = [np.broadcast_to(m.c, (len(m.c), *shape)) for m in models]
    return Model(np.stack(c, axis=1), np.stack([np.broadcast_to(m.r, shape) for m in models]))


def vector(x):
    return Model.constant(np.asarray(x, dtype=float).reshape(3, 1))


def total(products, axis):
    first, second, third = (products[(slice(None),) * axis + (i,)] for i in range(3))
    return first + second + third


def dot(a, b):
    return total(a * b, 0)


def cross(a, b):
    turned = [1, 2, 0], [2, 0, 1]
    return a[turned[0]] * b[turned[1]] - a[turned[1]] * b[turned[0]]


def apply(m, x):
    return total(m * x[np.newaxis], 1)


def transpose(m):
    return Model(np.swapaxes(m.c, 1, 2), np.swapaxes(m.r, 0, 1))


def product(a, b):
    return total(a[:, :, np.newaxis] * b[np.newaxis], 1)


def about(a, sin, cos):
    """The rotation about a unit vector by an angle with this sine and cosine."""
    versine, zero = cos.like(1.0) - cos, cos.like(0.0)
    x, y, z = (a[i] * sin for i in range(3))
    skew = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    rows = []
    for i in range(3):
        # Without a cosine that cancels along the axis.
        ones = [cos.like(float(i == j)) for j in range(3)]
        rows.append(stack([ones[j] + (a[i] * a[j] - ones[j]) * versine + skew[i][j] for j in range(3)]))
    return stack(rows)


IDENTITY = (Model.constant(np.eye(3).reshape(3, 3, 1)), vector([0.0, 0.0, 0.0]))


def compose(a, b):
    return product(a[0], b[0]), apply(a[0], b[1]) + a[1]


def inverse(a):
    back = transpose(a[0])
    return back, -apply(back, a[1])


def number(value, what="a number"):
    good = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    require(good, f"{what} is {value}, no finite number")
    return float(value)


def numbers(values, count=None):
    require(isinstance(values, list) and count in (None, len(values)), f"{count or 'several'} numbers are needed")
    return [number(value) for value in values]


def option(value, key, default=None):
    found = value.get(key) if isinstance(value, dict) else None
    return default if found is None else found


def get(value, key):
    found = option(value, key)
    require(found is not None, f"'{key}' is missing")
    return found


def attribute(node, name, default=0.0):
    return number(float(node.get(name, default))) if node is not None else default


def triple(node, name, default):
    words = node.get(name).split() if node is not None and node.get(name) is not None else default
    return numbers([float(word) for word in words], 3)


def pose(node):
    roll = triple(node, "rpy", [0.0, 0.0, 0.0])
    x, y, z = (about(IDENTITY[0][i], *Model.constant([roll[i]]).sin_cos()) for i in range(3))
    return product(z, product(y, x)), vector(triple(node, "xyz", [0.0, 0.0, 0.0]))


def quaternion(value):
    if value is None:
        return IDENTITY[0]
    q = Model.constant(np.array(numbers(value, 4)).reshape(4, 1))
    squares = q * q
    norm = (squares[0] + squares[1] + squares[2] + squares[3]).inverse_sqrt()
    x, y, z, w = (q[i] * norm for i in range(4))
    two, one = x.like(2.0), x.like(1.0)
    return stack([
        stack([one - two * (y * y + z * z), two * (x * y - z * w), two * (x * z + y * w)]),
        stack([two * (x * y + z * w), one - two * (x * x + z * z), two * (y * z - x * w)]),
        stack([two * (x * z - y * w), two * (y * z + x * w), one - two * (x * x + y * y)]),
    ])


def pose_of(value):
    return quaternion(option(value, "orientation_xyzw")), vector(numbers(get(value, "position_m"), 3))


def solid_of(shape):
    """The kind of an obstacle or a load and its lengths."""
    (kind, own), = shape.items()
    require(kind in ("sphere", "box", "cylinder", "capsule", "half_space"), f"shape '{kind}'")
    if kind == "box":
        return kind, [0.5 * x for x in numbers(get(own, "size_m"), 3)]
    return kind, [number(option(own, "radius_m", 0.0)), 0.5 * number(option(own, "length_m", 0.0))]


class Joint:
    """A joint and its body, in the frame of the joint."""

    def __init__(self, node, parent, origin):
        self.name, self.parent, self.origin = node.get("name"), parent, origin
        self.slides = node.get("type") == "prismatic"
        self.axis = unit(triple(node.find("axis"), "xyz", [1.0, 0.0, 0.0]))
        self.mass, self.first = Model.constant([0.0]), vector([0.0, 0.0, 0.0])
        self.inertia = Model.constant(np.zeros((3, 3, 1)))
        self.drive, self.limits = [Model.constant([0.0])] * 4, [-math.inf, math.inf, math.inf, math.inf]

    def read(self, node, scenario):
        limits = [attribute(node.find("limit"), key) for key in ("lower", "upper", "velocity", "effort")]
        if any(limits):
            self.limits = limits[:2] + [x if x > 0.0 else math.inf for x in limits[2:]]
            if node.get("type") == "continuous":
                self.limits[:2] = [-math.inf, math.inf]
        losses = option(scenario, "losses", False)
        if losses is False:
            return

        def given(key, default):
            found = option(losses, key, default)
            return number(option(found, self.name, default) if isinstance(found, dict) else found)

        damping, friction = (attribute(node.find("dynamics"), key) for key in ("damping", "friction"))
        width = given("friction_velocity", 0.02)
        drive = [given("damping", damping), given("friction", friction), 1.0, given("armature", 0.0)]
        self.drive = [Model.constant([x]) for x in drive]
        self.drive[2] = self.drive[2].over(width)

    def placement(self, q):
        if self.slides:
            return self.origin[0], self.origin[1] + apply(self.origin[0], self.axis * q[np.newaxis])
        return product(self.origin[0], about(self.axis, *q.sin_cos())), self.origin[1]


class Robot:
    """The moving bodies of a URDF and the balls that keep clear."""

    def __init__(self, urdf, scenario, names):
        root = ElementTree.fromstring(urdf)
        links = {link.get("name"): link for link in root.findall("link")}
        by_link = {}
        for joint in root.findall("joint"):
            for end in ("parent", "child"):
                by_link.setdefault(joint.find(end).get("link"), []).append((joint, end == "child"))
        carried = {joint.find("child").get("link") for joint in root.findall("joint")}
        bases = [link for link in links if link not in carried]
        require(bases, "no link is the base")
        base = option(scenario, "root", bases[0])
        require(base in links, "the robot has no such root")
        joints, placed, opened = {}, {}, [(base, None, IDENTITY, None)]
        while opened:
            link, body, at, before = opened.pop()
            require(link not in placed, "links form a loop")
            placed[link] = (body, at)
            for node, turned in by_link.get(link, []):
                if node is before:
                    continue
                # From a new root some joints are met from their other side: they turn back, and then comes the origin.
                step = pose(node.find("origin"))
                origin, then = (at, inverse(step)) if turned else (compose(at, step), IDENTITY)
                beyond, kind = node.find("parent" if turned else "child").get("link"), node.get("type")
                joint = Joint(node, body, origin)
                if turned:
                    joint.axis = -joint.axis
                locked = option(option(scenario, "locked_joints", {}), joint.name)
                if kind == "fixed":
                    opened.append((beyond, body, compose(origin, then), node))
                elif locked is not None:
                    placement = joint.placement(Model.constant([number(locked)]))
                    opened.append((beyond, body, compose(placement, then), node))
                else:
                    require(kind in ("revolute", "continuous", "prismatic"), f"joint type '{kind}'")
                    require(joint.name in names, f"joint '{joint.name}' has no motion{GROUP}")
                    joint.read(node, scenario)
                    i = names.index(joint.name)
                    joints[i] = joint
                    opened.append((beyond, i, then, node))
        require(len(joints) == len(names), "the motion has a joint that the robot has not")
        self.joints = [joints[i] for i in range(len(names))]
        self.base, self.links = (Model.constant([0.0]), vector([0.0] * 3)), placed
        early = all(joint.parent is None or joint.parent < i for i, joint in enumerate(self.joints))
        require(early, "a joint is before its parent")
        for link, (body, at) in placed.items():
            inertial = links[link].find("inertial")
            if inertial is not None:
                six = [attribute(inertial.find("inertia"), k) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]
                mass = attribute(inertial.find("mass"), "value")
                self.add_mass(body, compose(at, pose(inertial.find("origin"))), mass, six)
        load = option(scenario, "payload")
        if load is not None:
            body, at = placed[get(load, "link")]
            center = (IDENTITY[0], vector(numbers(option(load, "center_m", [0.0] * 3), 3)))
            six = numbers(option(load, "inertia_kg_m2", [0.0] * 6), 6)
            self.add_mass(body, compose(at, center), number(get(load, "mass_kg")), six)
        # Per shape the body, the link, the placement, the kind and the lengths.
        self.parts, self.is_known = [], True
        self.add_parts(scenario, links, placed)
        self.has_balls = self.is_known and all(kind == "sphere" for _, _, _, kind, _ in self.parts)

    def add_mass(self, body, at, mass, six):
        c = at[1]
        if body is None:
            self.base = self.base[0] + Model.constant([mass]), self.base[1] + c * Model.constant([mass])
            return
        joint = self.joints[body]
        xx, xy, xz, yy, yz, zz = six
        own = Model.constant(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).reshape(3, 3, 1))
        mass = Model.constant([mass])
        square = IDENTITY[0] * dot(c, c) - c[:, np.newaxis] * c[np.newaxis]
        joint.mass, joint.first = joint.mass + mass, joint.first + c * mass
        joint.inertia = joint.inertia + product(product(at[0], own), transpose(at[0])) + square * mass

    def add_parts(self, scenario, links, placed):
        """Adds the shapes of the robot, by the names of their links."""

        def add_ball(body, link, centre, radius):
            self.parts.append((body, link, (IDENTITY[0], centre), "sphere", [radius]))

        is_shaped = any(link.find("collision") is not None for link in links.values())
        shape = option(scenario, "robot_shape", "collision" if is_shaped else "joint_frames")
        by_shapes = shape == "collision" or option(shape, "collision") is not None
        if shape == "joint_frames":
            for body in range(len(self.joints)):
                add_ball(body, "", vector([0.0] * 3), 0.0)
        elif option(shape, "swept_links") is not None:
            swept = shape["swept_links"]
            radius, spacing = number(get(swept, "radius_m")), number(option(swept, "spacing_m", 0.05))
            for body in range(len(self.joints)):
                ends = [joint.origin[1] for joint in self.joints if joint.parent == body]
                ends += [at[1] for of, at in placed.values() if of == body]
                ends = [end for end in ends if np.any(end.c[0] != 0.0)] or [vector([0.0] * 3)]
                for end in ends:
                    length = math.sqrt(float((end.c[0] ** 2).sum()))
                    pieces = max(math.ceil(length / spacing), 1)
                    for i in range(pieces + 1):
                        centre = end * Model.constant(float(i)).over(float(pieces))
                        add_ball(body, "", centre, math.hypot(radius, 0.5 * length / pieces))
        else:
            for link, (body, at) in sorted(placed.items()):
                for collision in links[link].findall("collision"):
                    (own, *_) = collision.find("geometry")
                    if own.tag not in ("sphere", "cylinder", "capsule", "box"):
                        self.is_known = False
                        continue
                    size = [attribute(own, "radius"), 0.5 * attribute(own, "length")]
                    if own.tag == "box":
                        size = [0.5 * x for x in triple(own, "size", [0.0] * 3)]
                    self.parts.append((body, link, compose(at, pose(collision.find("origin"))), own.tag, size))
        load = option(scenario, "payload")
        if option(load, "shape") is not None:
            kind, size = solid_of(load["shape"])
            body, at = placed[load["link"]]
            default = {"position_m": option(load, "center_m", [0.0] * 3)}
            self.is_known &= by_shapes or kind == "sphere"
            at = compose(at, pose_of(option(load, "shape_pose", default)))
            self.parts.append((body, load["link"], at, kind, size))

    def torques(self, q, v, a):
        """Inverse dynamics by the recursive Newton-Euler algorithm in the frames of the joints: the torques, and the
        force on the base and its moment about the origin."""
        zero, gravity = vector([0.0] * 3), vector([0.0, 0.0, 9.81])
        places, moving, loads = [], [], []
        ground = [gravity * self.base[0], cross(self.base[1], gravity)]
        for i, joint in enumerate(self.joints):
            place = joint.placement(q[i])
            spin, turning, speeding = (zero, zero, gravity) if joint.parent is None else moving[joint.parent]
            inverse = transpose(place[0])
            speeding = speeding + cross(turning, place[1]) + cross(spin, cross(spin, place[1]))
            spin, turning, speeding = (apply(inverse, x) for x in (spin, turning, speeding))
            rate, second = joint.axis * v[i], joint.axis * a[i]
            if joint.slides:
                coriolis = cross(spin, rate)
                speeding = speeding + second + coriolis + coriolis
            else:
                turning = turning + second + cross(spin, rate)
                spin = spin + rate
            h = joint.first
            force = speeding * joint.mass + cross(turning, h) + cross(spin, cross(spin, h))
            moment = apply(joint.inertia, turning) + cross(spin, apply(joint.inertia, spin)) + cross(h, speeding)
            places.append(place)
            moving.append((spin, turning, speeding))
            loads.append([force, moment])
        torques = [None] * len(self.joints)
        for i, joint in reversed(list(enumerate(self.joints))):
            force, moment = loads[i]
            damping, friction, per_width, armature = joint.drive
            x = v[i] * per_width
            torques[i] = dot(joint.axis, force if joint.slides else moment) + v[i] * damping + a[i] * armature
            if friction.c[0].item() > 0.0:
                torques[i] = torques[i] + x * friction * (x.like(1.0) + x * x).inverse_sqrt()
            force = apply(places[i][0], force)
            moment = apply(places[i][0], moment) + cross(places[i][1], force)
            below = ground if joint.parent is None else loads[joint.parent]
            below[:] = [below[0] + force, below[1] + moment]
        return stack(torques), ground

    def weight(self):
        return 9.81 * sum(joint.mass.c[0].item() for joint in self.joints) + 9.81 * self.base[0].c[0].item()

    def places(self, q):
        """The placements of the bodies in the base frame."""
        places = []
        for i, joint in enumerate(self.joints):
            own = joint.placement(q[i])
            places.append(own if joint.parent is None else compose(places[joint.parent], own))
        return places

    def placed(self, places):
        """The placements of the shapes in the base frame."""
        return [at if body is None else compose(places[body], at) for body, _, at, _, _ in self.parts]


class States:
    """The states of a robot: positions, velocities and the placements of its bodies. A row of them is a name, a
    quantity, its bounds and the unit of reserves."""

    def __init__(self, robot, q, v):
        self.robot, self.q, self.v, self.places = robot, q, v, robot.places(q)

    def link(self, name):
        body, at = self.robot.links[name]
        return at if body is None else compose(self.places[body], at)

    def poses(self, goal):
        """The rows of a set of poses."""
        turn, at = self.link(get(goal, "frame"))
        if option(goal, "relative_to") is not None:
            other = self.link(goal["relative_to"])
            turn, at = product(transpose(other[0]), turn), apply(transpose(other[0]), at - other[1])
        rows = []
        if option(goal, "position_m") is not None:
            off, r = at - vector(numbers(goal["position_m"], 3)), option(goal, "tolerance_m")
            if r is None:
                rows += [zero("position", off[i]) for i in range(3)]
            else:
                square = dot(off, off)
                rows.append(most("distance", square - square.like(number(r)) * square.like(r), 2.0 * r))
        if option(goal, "box") is not None:
            centre, sizes = pose_of(get(goal["box"], "pose")), get(goal["box"], "size_m")
            off = apply(transpose(centre[0]), at - centre[1])
            require(len(sizes) == 3, "a box has three edges")
            for i, size in enumerate(sizes):
                if size == 0.0:
                    rows.append(zero("position", off[i]))
                elif size is not None:
                    rows.append(("position in a box", off[i], [-0.5 * number(size), 0.5 * size], 1.0))
        within = option(goal, "tolerance_rad")
        if option(goal, "orientation_xyzw") is not None:
            m = product(transpose(quaternion(goal["orientation_xyzw"])), turn)
            sine = stack([(m[i, j] - m[j, i]).over(2.0) for i, j in ((2, 1), (0, 2), (1, 0))])
            rows += angle(sine, (m[0, 0] + m[1, 1] + m[2, 2] - m[0, 0].like(1.0)).over(2.0), within)
        elif option(goal, "axis") is not None:
            own, aim = (unit(numbers(get(goal["axis"], key), 3)) for key in ("of_frame", "direction"))
            own = apply(turn, own)
            rows += angle(cross(own, aim), dot(own, aim), within)
        require(rows, "a set of poses has no condition")
        return rows

    def kept(self, condition):
        """The rows of a condition along the way."""
        if option(condition, "poses") is not None:
            return self.poses(condition["poses"])
        of = get(condition, "speed")
        turn, at = self.link(get(of, "frame"))
        point = apply(turn, vector(numbers(option(of, "point_m", [0.0] * 3), 3))) + at
        body, velocity = self.robot.links[of["frame"]][0], vector([0.0] * 3)
        while body is not None:
            joint, (turn, at) = self.robot.joints[body], self.places[body]
            axis = apply(turn, joint.axis)
            velocity = velocity + (axis if joint.slides else cross(axis, point - at)) * self.v[body]
            body = joint.parent
        square, bound = dot(velocity, velocity), number(get(of, "most_m_s"))
        return [most("speed", square - square.like(bound) * square.like(bound), 2.0 * bound)]

    def waypoint(self, point):
        """The rows of a waypoint."""
        rows = self.poses(point["poses"]) if option(point, "poses") is not None else []
        if option(point, "q") is not None:
            aims = numbers(point["q"], len(self.robot.joints))
            rows += [zero("position", self.q[i] - self.q[i].like(aim)) for i, aim in enumerate(aims)]
        if option(point, "stop", False):
            rows += [zero("velocity", self.v[i]) for i in range(len(self.robot.joints))]
        require(rows, "a waypoint has no condition")
        return rows

    def foot(self, stand, force, moment):
        """The rows of a standing foot under the force of the ground on the base and its moment."""
        turn, at = self.link(get(stand, "frame"))
        if option(stand, "sole") is not None:
            turn, at = compose((turn, at), pose_of(stand["sole"]))
        force, moment = apply(transpose(turn), force), apply(transpose(turn), moment - cross(at, force))
        up, weight, friction = force[2], self.robot.weight(), number(get(stand, "friction"))
        rows = [most("normal force", -up, weight)]
        for i, key in ((1, "half_length_m"), (0, "half_width_m"), (2, "torsion")):
            if key != "torsion" or option(stand, key) is not None:
                side = up * up.like(number(get(stand, key)))
                rows += [most(key, moment[i] - side, weight), most(key, -moment[i] - side, weight)]
        bound = up * up.like(friction)
        slip = (force[0] * force[0] + force[1] * force[1] - bound * bound).over(2.0 * friction)
        return [*rows, most("friction", slip, weight**2)]


def most(name, x, scale):
    return name, x, [-math.inf, 0.0], scale


def zero(name, x):
    return name, x, [-EQUALITY, EQUALITY], 1.0


def angle(sine, cosine, within):
    """The rows of an angle with this sine, times an axis, and cosine, at most a bound or, without one, zero."""
    bound = math.pi / 3.0 if within is None else number(within)
    rows = [most("angle", cosine.like(math.cos(bound)) - cosine, math.sin(bound))]
    return rows + ([zero("angle", sine[i]) for i in range(3)] if within is None else [])


def unit(axis):
    axis = vector(axis)
    return axis * dot(axis, axis).inverse_sqrt()[np.newaxis]


class Motion:
    """The piecewise polynomial motion: its Chebyshev coefficients per segment and joint, and its horizon."""

    def __init__(self, coefficients, horizon):
        self.coefficients, self.horizon, self.segments = coefficients, horizon, len(coefficients)

    def time(self, segment, x):
        """The time of a place, s, with an error of less than 1e-15 of the horizon."""
        return (segment + 0.5 * (1.0 + x)) * self.horizon / self.segments

    def states(self, robot, segment, x):
        """The states at a place."""
        own = self.expand([segment], np.array([x]), np.array([2.0**-20]))[:2]
        return States(robot, *(Model.constant(part.c[0]).widened(part.r) for part in own))

    def expand(self, own, middles, halves):
        """Positions, velocities, accelerations and jerks of the joints on parts |x - m| <= w of segments, as
        coefficients and bounds on errors: Taylor coefficients about m from the Chebyshev coefficients of the
        derivatives."""

        def ball(x):
            return Model.constant(x, order=1)

        count, coefficients = len(middles), self.coefficients
        degree = coefficients.shape[-1] - 1
        m, w = ball(middles), ball(halves)
        chebyshev = [ball(np.ones(count)), m]
        for j in range(2, degree + 1):
            twice = chebyshev[j // 2] * chebyshev[j - j // 2] * ball(2.0)
            chebyshev.append(twice - (chebyshev[1] if j % 2 else chebyshev[0]))
        rate = ball(np.full(count, 2.0 * self.segments)).over(self.horizon).over(halves)
        # Per degree, joints by segments.
        c = [ball(coefficients[:, :, j].T) for j in range(degree + 1)]
        power, taylor = ball(np.ones(count)), []
        for k in range(degree + 1):
            value = ball(np.zeros((coefficients.shape[1], count)))
            for j, cj in enumerate(c):
                value = value + cj[:, own] * chebyshev[j]
            taylor.append(value * power)
            power = power * w
            n = len(c) - 1
            # The next derivative over k + 1.
            rates = [ball(np.zeros(c[0].r.shape)) for _ in range(n + 2)]
            for j in range(n, 0, -1):
                rates[j - 1] = rates[j + 1] + c[j] * ball(2.0 * j)
            rates = rates[:n]
            if rates:
                rates[0] = rates[0].over(2.0)
            c = [x.over(float(k + 1)) for x in rates]
        found = []
        for _ in range(4):
            c = np.concatenate([x.c for x in taylor])
            found.append(Model(c, sum(x.r for x in taylor) * UP))
            taylor = [x * ball(float(k)) * rate for k, x in enumerate(taylor) if k > 0] or [taylor[0] * ball(0.0)]
        return found


def cut(polynomials):
    """The polynomials with ORDER coefficients."""
    c = polynomials.c
    padded = np.zeros((ORDER, *c.shape[1:]))
    padded[: min(ORDER, len(c))] = c[:ORDER]
    return Model(padded, polynomials.r).widened(np.abs(c[ORDER:]).sum(axis=0) * UP)


def bernstein(n):
    """The Bernstein coefficients of the powers of s on [-1, 1]: one row per power."""

    def raised(b, sign):
        m = len(b)
        share = np.arange(m + 1) / m
        return share * np.append(0.0, b) + sign * share[::-1] * np.append(b, 0.0)

    power, rows = np.ones(1), []
    for k in range(n + 1):
        row = power
        for _ in range(k, n):
            row = raised(row, 1.0)
        rows.append(row)
        power = raised(power, -1.0)
    return np.array(rows)


def least(polynomials, enough, accuracy):
    """Lower bounds on the values of polynomials, a list of them, which need not be above `enough`, nor closer than
    `accuracy` to the least values."""
    c = polynomials.c
    n, count = len(c) - 1, c.shape[1]
    b = bernstein(n).T @ c
    error = (polynomials.r + 64.0 * (n + 1) * 2.0 * UNIT * np.abs(c).sum(axis=0)) * UP + TINY
    found, reached = np.full(count, np.inf), np.minimum(b[0], b[-1])
    enough = np.broadcast_to(enough, count) + error
    of = np.arange(count)
    for level in range(24):
        low = b.min(axis=0)
        is_last = (level == 23) | (len(of) > 4_000_000)
        is_done = (low >= enough[of]) | (low + accuracy >= reached[of]) | ~np.isfinite(low) | is_last
        np.minimum.at(found, of[is_done], low[is_done])
        right, of = b[:, ~is_done].copy(), of[~is_done]
        if len(of) == 0:
            break
        left = np.empty_like(right)
        left[0] = right[0]
        for j in range(1, n + 1):
            right[: n + 1 - j] = 0.5 * (right[: n + 1 - j] + right[1 : n + 2 - j])
            left[j] = right[0]
        np.minimum.at(reached, of, np.minimum(right[0], right[-1]))
        b, of = np.concatenate([left, right], axis=1), np.concatenate([of, of])
    bound = np.nextafter(found - error, -np.inf)
    return np.where(np.isfinite(error) & np.isfinite(bound), bound, -np.inf)


def limits_of(scenario, robot):
    """The limits that a scenario enforces: promise, joint, bounds."""
    enforced, passive = option(scenario, "enforced_limits", {}), option(scenario, "passive", [])

    def share(key, joint):
        found = option(enforced, key, True)
        if isinstance(found, bool):
            return 1.0 if found else None
        if isinstance(found, dict):
            return number(option(found, "share", 1.0)) if joint in option(found, "joints", [joint]) else None
        return number(found)

    def most(key, i):
        found = option(enforced, key)
        if isinstance(found, list):
            found = found[i]
        return math.inf if found is None else number(found, f"{key} (use the scenario of the summary)")

    limits = []
    for promise in KINDS:
        for i, joint in enumerate(robot.joints):
            lower, upper, velocity, effort = joint.limits
            part = share(promise, joint.name) if promise in ("position", "velocity", "torque") else None
            bounds = [-math.inf, math.inf]
            if promise == "position" and part is not None:
                cut_off = 0.5 * (1.0 - part) * (upper - lower)
                bounds = [lower + cut_off, upper - cut_off] if math.isfinite(cut_off) else [lower, upper]
            elif promise == "velocity" and part is not None:
                bounds = [-part * velocity, part * velocity]
            elif promise == "torque" and part is not None and joint.name not in passive:
                bounds = [-part * effort, part * effort]
            if promise in ("velocity", "acceleration", "jerk"):
                given = most("max_velocity" if promise == "velocity" else promise, i)
                bounds = [max(bounds[0], -given), min(bounds[1], given)]
            if any(map(math.isfinite, bounds)):
                limits.append((promise, i, bounds))
    return limits


def obstacles_of(scenario):
    """The obstacles: placement, kind, lengths, and the distance that is kept."""
    given = option(scenario, "clearance_m", 0.0)
    beside = number(option(given, "obstacles", 0.0) if isinstance(given, dict) else given)
    found = []
    for obstacle in option(scenario, "obstacles", []):
        margin = number(option(obstacle, "clearance_m", beside))
        found.append((pose_of(get(obstacle, "pose")), *solid_of(get(obstacle, "shape")), margin))
    return found


def lower(x):
    return least(x, np.inf, 1e-12)


def length(vectors):
    """Lower bounds on the lengths of vectors, a list of lists of coordinates."""
    square = vectors[0] * vectors[0]
    for x in vectors[1:]:
        square = square + x * x
    return np.sqrt(np.maximum(lower(square), 0.0)) * (1.0 - 4.0 * UNIT)


def distance(obstacle, p):
    """Lower bounds on the signed distances of points, 3 by their number, from the surface of an obstacle."""
    (turn, at), kind, size, _ = obstacle
    p = apply(transpose(turn), p - at)

    def beyond(i, half):
        sign = np.where(p.c[0, i] < 0.0, -1.0, 1.0)
        off = Model(p.c[:, i] * sign, p.r[i]) - p[i].like(half)
        return off, lower(off)

    if kind == "sphere":
        return length([p[0], p[1], p[2]]) - size[0]
    if kind == "half_space":
        return lower(p[2])
    if kind == "box":
        faces = [beyond(i, size[i]) for i in range(3)]
        out = np.array([face[1] >= 0.0 for face in faces])
        flat = np.max([face[1] for face in faces], axis=0)
        corner = length([Model(face[0].c * out[i], face[0].r * out[i]) for i, face in enumerate(faces)])
        return np.where(out.sum(axis=0) >= 2, corner, flat)
    off, along = beyond(2, size[1])
    if kind == "capsule":
        capped = length([p[0], p[1], off])
        return np.where(along >= 0.0, capped, length([p[0], p[1]])) - size[0]
    across = length([p[0], p[1]]) - size[0]
    corner = np.hypot(across, along) * (1.0 - 4.0 * UNIT)
    return np.where((along >= 0.0) & (across >= 0.0), corner, np.maximum(across, along))


def pairs_of(scenario, certificate, robot):
    """Per promise the pairs of a shape, an obstacle or another shape, and the distance that is kept."""
    if not robot.is_known:
        return {}
    obstacles, given = obstacles_of(scenario), option(scenario, "clearance_m", 0.0)
    itself = number(option(given, "itself", 0.0) if isinstance(given, dict) else given)
    own = {frozenset(p["links"]): number(p["clearance_m"]) for p in option(given, "pairs", [])}
    free = {frozenset(pair) for pair in get(certificate, "may_overlap")}
    found = {"obstacles": [], "self_collision": []}
    for i, (body, link, *_) in enumerate(robot.parts):
        if body is not None:
            found["obstacles"] += [(i, o, obstacle[3]) for o, obstacle in enumerate(obstacles)]
        for j, (other, beside, *_) in enumerate(robot.parts[i + 1 :], i + 1):
            names = frozenset((link, beside))
            apart = link and beside and link != beside and body != other and names not in free
            if apart and option(scenario, "self_collision") != "off":
                found["self_collision"].append((i, j, own.get(names, itself)))
    return {promise: pairs for promise, pairs in found.items() if pairs}


def proved(row, claims):
    """True where a row keeps its bounds and the claims beyond them."""
    _, value, bounds, scale = row
    good = np.full(claims.shape, True)
    for sign, bound in ((1.0, bounds[0]), (-1.0, -bounds[1])):
        if math.isfinite(bound):
            wanted = bound + claims * scale
            good &= least(Model(sign * value.c, value.r), wanted, 1e-13 * scale) >= wanted
    return good


def check_places(scenario, certificate, robot, motion):
    """Checks the claims on the goal, if it is a set of poses, and on the waypoints."""

    def fault(rows, claim):
        """The first row that is not proved."""
        require(number(claim) >= -TOLERANCE, "a reserve is negative")
        return next((row[0] for row in rows if not np.all(proved(row, np.array([claim])))), None)

    goals = option(scenario, "goal", [])
    goals = goals if isinstance(goals, list) else [goals]
    if goals:
        end, claim = motion.states(robot, motion.segments - 1, 1.0), get(certificate, "goal")
        require(any(fault(end.poses(goal), claim) is None for goal in goals), "the goal is not proved")
    points, places = option(scenario, "waypoints", []), get(certificate, "waypoints")
    require(len(points) == len(places), "the waypoints are not those of the scenario")
    before = [0, -1.0]
    for i, (point, place) in enumerate(zip(points, places)):
        segment, x, claim = numbers(place, 3)
        known = segment in range(motion.segments) and abs(x) <= 1.0
        require(known, f"waypoint {i}: the place is not in the motion")
        wrong = fault(motion.states(robot, int(segment), x).waypoint(point), claim)
        require(wrong is None, f"waypoint {i}: {wrong} is not proved")
        time = motion.time(segment, x)
        off = abs(time - number(option(point, "time_s", time)))
        require(off <= SAME_TIME * motion.horizon, f"waypoint {i}: it has another time")
        require(before <= [segment, x], f"waypoint {i}: it is before another one")
        before = [segment, x]


def extent(at, kind, size, n):
    """An upper bound on the extent of a shape from its centre in a direction and against it: that of a ball, of edges,
    or of an axis and a disc."""

    def half(square, length):
        """An upper bound on a root, (x + b) / (2 sqrt b) for any positive b, times a length."""
        near = np.maximum(np.maximum(square.c[0], 0.3 * square.variation()), 1e-12)
        bound = (square + square.like(near)).over(2.0 * np.sqrt(near))
        # The root in the divisor is rounded.
        return bound.widened(4.0 * UNIT * bound.most()) * bound.like(length)

    x = apply(transpose(at[0]), n)
    squares, ball = [x[i] * x[i] for i in range(3)], dot(n, n)
    if kind == "box":
        return half(squares[0], size[0]) + half(squares[1], size[1]) + half(squares[2], size[2])
    if kind == "half_space":
        return ball.like(0.0)
    if kind == "sphere":
        return half(ball, size[0])
    return half(squares[2], size[1]) + half(ball if kind == "capsule" else squares[0] + squares[1], size[0])


def check_shapes(promise, pairs, claims, robot, obstacles, placed, directions, place):
    """Checks that directions separate all pairs by their distances and the claims of the intervals beyond them."""
    for i, j, margin in pairs:
        b, key = ((placed[j], *robot.parts[j][3:]), j) if promise != "obstacles" else (obstacles[j], len(placed) + j)
        off = b[0][1] - placed[i][1]
        if b[1] == "half_space":
            n = -transpose(b[0][0])[2]
        else:
            n = Model.constant(off.c[0] + np.zeros((3, len(claims))))
            for k, direction in directions.get((i, key), []):
                n.c[0, :, k] = direction
        gap = dot(n, off) - extent(placed[i], *robot.parts[i][3:], n) - extent(*b[:3], n)
        square = dot(n, n)
        good = lower(gap) >= (claims + margin) * np.sqrt(square.most()) * (1.0 + 4.0 * UNIT)
        good &= square.c[0] > 1e-6
        require(np.all(good), place(promise, np.flatnonzero(~good)))


def check_balls(promise, pairs, claims, robot, obstacles, placed, place):
    """Checks that all pairs keep their distances and the claims of the intervals beyond them."""
    centres = stack([at[1] + Model.constant(np.zeros((3, claims.size))) for at in placed])
    radii = np.array([part[4][0] for part in robot.parts])
    middles = Model.constant(centres.c[0])
    ways = (np.sqrt((centres.variation() ** 2).sum(axis=1)) + 1e-12) * UP

    def prove(of, beside, margin, points, others, by, way):
        """True where the bound on the distances of these points, less the ways of both balls, is above the claim."""
        i, k = of
        p = points[i, :, k]
        p = Model(np.moveaxis(p.c, 0, 2), p.r.T)
        if promise == "obstacles":
            surface = distance(obstacles[beside], p)
        else:
            q = others[by, :, k]
            off = p - Model(np.moveaxis(q.c, 0, 2), q.r.T)
            surface = length([off[0], off[1], off[2]]) - radii[by]
        return surface - radii[i] - margin - way >= claims[k]

    groups = {}
    for i, j, margin in pairs:
        groups.setdefault(j if promise == "obstacles" else None, []).append((i, j, margin))
    for beside, group in groups.items():
        count = claims.size
        i, j = (np.repeat([pair[x] for pair in group], count) for x in (0, 1))
        margin, k = np.repeat([pair[2] for pair in group], count), np.tile(np.arange(count), len(group))
        way = ways[i, k] + (0.0 if promise == "obstacles" else ways[j, k])
        # The distance in the middle less the ways from there is enough for most.
        is_left = ~prove((i, k), beside, margin, middles, middles, j, way)
        i, j, k, margin = i[is_left], j[is_left], k[is_left], margin[is_left]
        if len(i):
            good = prove((i, k), beside, margin, centres, centres, j, 0.0)
            require(np.all(good), place(promise, k[~good]))


def xxh64(text):
    """The 64-bit xxHash of bytes, with the seed zero."""
    primes = [0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5]
    mask = 2**64 - 1
    p1, p2, p3, p4, p5 = primes

    def turned(x, by):
        return ((x << by) | (x >> (64 - by))) & mask

    def rounded(a, word):
        return turned((a + word * p2) & mask, 31) * p1 & mask

    def word(i, size=8):
        return int.from_bytes(text[i : i + size], "little")

    value, i = p5, 0
    if len(text) >= 32:
        lanes = [(p1 + p2) & mask, p2, 0, -p1 & mask]
        while i + 32 <= len(text):
            lanes = [rounded(lane, word(i + 8 * j)) for j, lane in enumerate(lanes)]
            i += 32
        value = sum(turned(lane, by) for lane, by in zip(lanes, (1, 7, 12, 18))) & mask
        for lane in lanes:
            value = ((value ^ rounded(0, lane)) * p1 + p4) & mask
    value = (value + len(text)) & mask
    while i + 8 <= len(text):
        value, i = (turned(value ^ rounded(0, word(i)), 27) * p1 + p4) & mask, i + 8
    if i + 4 <= len(text):
        value, i = (turned(value ^ (word(i, 4) * p1 & mask), 23) * p2 + p3) & mask, i + 4
    for byte in text[i:]:
        value = turned(value ^ (byte * p5 & mask), 11) * p1 & mask
    value = (value ^ (value >> 33)) * p2 & mask
    value = (value ^ (value >> 29)) * p3 & mask
    return value ^ (value >> 32)


def check_deviations(scenario, claims, motion):
    """Checks the claims on the states at the ends and between segments."""
    every, short = np.arange(motion.segments), np.full(motion.segments, 2.0**-20)
    # Short intervals about both ends of each segment, where Chebyshev polynomials are exact.
    start, end = (motion.expand(every, np.full(motion.segments, x), short) for x in (-1.0, 1.0))

    def check(name, deviations, most):
        claim = number(get(claims, name), name)
        require(claim <= most and np.all(deviations.most() <= claim), f"{name} is not proved")

    def middle(polynomials, segment):
        return Model(polynomials.c[:1, :, segment], polynomials.r[:, segment])

    def off(polynomials, segment, key):
        count = polynomials.r.shape[0]
        wanted = numbers(option(scenario, key, [0.0] * count), count)
        return middle(polynomials, segment) - Model.constant(wanted, order=1)

    passive, is_set = option(scenario, "passive", []), option(scenario, "goal", [])
    check("start_position", off(start[0], 0, "q_start"), STATE)
    check("start_velocity", off(start[1], 0, "v_start"), STATE)
    if not is_set:
        check("goal_position", off(end[0], -1, "q_goal"), STATE)
    if not option(scenario, "free_final_velocity", False):
        check("goal_velocity", off(end[1], -1, "v_goal"), STATE)
    orders = ["position", "velocity", "acceleration"]
    is_smooth = option(scenario, "continuity", "velocity" if passive else "acceleration") == "acceleration"
    if start[0].r.shape[1] > 1:
        for order, name in enumerate(orders if is_smooth else orders[:2]):
            jump = middle(end[order], slice(0, -1)) - middle(start[order], slice(1, None))
            check(f"jump_{name}", jump, STATE if order < 2 else ACCELERATION)


def not_certified(scenario, robot, listed):
    """The promises of a scenario that no certificate covers, which the certificate has to list."""
    shape = option(scenario, "robot_shape", "collision")
    by_shape = shape == "collision" or option(shape, "collision") is not None
    apart = by_shape and option(scenario, "self_collision") != "off"
    wanted = [
        ("passive_joints", option(scenario, "passive")),
        ("obstacles", not robot.is_known and option(scenario, "obstacles")),
        ("self_collision", not robot.is_known and apart),
    ]
    wanted = [name for name, is_missing in wanted if is_missing]
    require([get(entry, "promise") for entry in listed] == wanted, f"what is not certified is {wanted}")
    return wanted


def check_limits(limits, listed):
    require(len(limits) == len(listed), "the limits are not those of the scenario")
    for (promise, joint, bounds), row in zip(limits, listed):
        own = [option(row, "at_least", -math.inf), option(row, "at_most", math.inf)]
        same = all(x == y or abs(x - y) <= 1e-14 * abs(y) for x, y in zip(own, bounds))
        is_it = get(row, "promise") == promise and get(row, "joint") == joint
        require(same and is_it, f"a {promise} limit is not that of the scenario")


def weighs_time(scenario):
    """True if the objective has a cost of time, so that the horizon is free."""
    objective = option(scenario, "objective", "least-effort")
    if isinstance(objective, str):
        return objective != "least-effort"
    return number(option(objective, "time", 0.0)) > 0.0


def cover(intervals, segments, claims):
    """The segments, middles, half widths and claims of intervals that cover the horizon, and per pair of shapes the
    intervals with a direction, and these."""
    segment, before, found, directions = 0, -1.0, [], {}
    for interval in intervals:
        require(isinstance(interval, list) and len(interval) == 5, "an interval has five entries")
        own, (begin, end), reserves = interval[0], numbers(interval[1:3]), numbers(interval[3], claims)
        if before == 1.0:
            segment, before = segment + 1, -1.0
        m, w = 0.5 * (begin + end), 0.5 * (end - begin)
        exact = m - w == begin and m + w == end and w > 0.0 and end <= 1.0 and not isinstance(own, bool)
        good = own == segment and segment < segments and begin == before and exact
        require(good, "the intervals do not cover the horizon")
        require(all(x >= -TOLERANCE for x in reserves), "a reserve is negative")
        before = end
        found.append((segment, m, w, reserves))
        for i, j, n in interval[4]:
            directions.setdefault((i, j), []).append((len(found) - 1, numbers(n, 3)))
    require(segment == segments - 1 and before == 1.0, "the intervals do not cover the horizon")
    return found, directions


def check(robot, scenario, run, certificate):
    """Checks a certificate, given the texts of the robot, of the scenario (or of a summary that contains it), of the
    summary of the solve and of the certificate; returns what is certified in words, or raises `Refused`."""

    def refuse(name):
        raise Refused(f"{name} is no number")

    try:
        scenario, run, certificate = (json.loads(x, parse_constant=refuse) for x in (scenario, run, certificate))
        return _check(robot, option(option(scenario, "provenance"), "scenario", scenario), run, certificate)
    except (ValueError, TypeError, KeyError, AttributeError, LookupError, ElementTree.ParseError) as error:
        raise Refused(f"unreadable: {error!r}") from error


def check_intervals(scenario, robot, motion, tube, limits, pairs, promises, intervals, directions):
    """Checks the claims on all intervals, for positions within the tube about the motion."""
    of, middles, halves, claims = (np.array(list(column)) for column in zip(*intervals))
    claims = dict(zip(promises, claims.reshape(len(intervals), len(promises)).T))

    def place(what, k):
        if len(k) == 0:
            return ""
        first = intervals[int(np.min(k))]
        return f"segment {first[0]} from {first[1] - first[2]} to {first[1] + first[2]}: {what} is not proved"

    always, rounding = np.full(len(intervals), True), 1e-15 * motion.horizon
    begin, end = (motion.time(of, x) for x in (middles - halves, middles + halves))
    quantities = motion.expand(of, middles, halves)
    quantities[0] = quantities[0].widened(tube)
    q, v, a = (cut(part) for part in quantities[:3])
    states, rows = States(robot, q, v), []
    if "torque" in promises or "stand" in promises:
        torques, ground = robot.torques(q, v, a)
        quantities.append(torques)
        if "stand" in promises:
            rows += [("stand", row, always) for row in states.foot(scenario["stand"], *ground)]
    for promise, joint, bounds in limits:
        scale = max(abs(x) for x in bounds if math.isfinite(x)) or 1.0
        name, value = f"{promise} of joint '{robot.joints[joint].name}'", quantities[KINDS.index(promise)][joint]
        rows.append((promise, (name, value, bounds, scale), always))
    for condition in option(scenario, "keep", []):
        from_s, to_s = (number(option(condition, *key)) for key in (("from_s", 0.0), ("to_s", motion.horizon)))
        inside = (end + rounding > from_s) & (begin - rounding < to_s)
        rows += [("keep", row, inside) for row in states.kept(condition)]
    for promise, row, inside in rows:
        good = proved(row, claims[promise]) | ~inside
        require(np.all(good), place(row[0], np.flatnonzero(~good)))
    if pairs:
        obstacles, placed = obstacles_of(scenario), robot.placed(states.places)
        for promise, own in pairs.items():
            if robot.has_balls:
                check_balls(promise, own, claims[promise], robot, obstacles, placed, place)
            else:
                check_shapes(promise, own, claims[promise], robot, obstacles, placed, directions, place)


def _check(robot, scenario, run, certificate):
    def given(key):
        return get(certificate, key)

    require(given("format") == "aghf-certificate-3", "another format")
    require(number(given("tolerance")) == TOLERANCE, "another tolerance")
    require(given("robot_xxh64") == f"{xxh64(robot.encode()):016x}", "another robot")
    curve, names = get(run, "curve"), given("joints")
    require(names == get(curve, "joints"), "the joints are not those of the run")
    own = [joints[: len(names)] for joints in get(curve, "coefficients")]
    require(given("coefficients") == own, "the coefficients are not those of the run")
    coefficients = np.array([[numbers(joint, len(own[0][0])) for joint in segment] for segment in own])
    require(coefficients.ndim == 3 and coefficients.shape[1] == len(names), "a joint has no coefficients")
    horizon = number(given("horizon_s"))
    require(horizon == get(curve, "horizon_s"), "the horizon is not that of the run")
    free = option(scenario, "free_horizon")
    if free:
        wanted = [get(free, key) for key in ("shortest_s", "longest_s")]
    else:
        wanted = [0.0, math.inf] if weighs_time(scenario) else [get(scenario, "horizon_s")] * 2
    require(0.0 < horizon and wanted[0] <= horizon <= wanted[1], "the horizon is not that of the scenario")
    robot = Robot(robot, scenario, names)
    missing = not_certified(scenario, robot, given("not_certified"))
    require(given("complete") is (not missing), "'complete' is wrong")
    limits = limits_of(scenario, robot)
    check_limits(limits, given("limits"))

    motion = Motion(coefficients, horizon)
    check_deviations(scenario, given("deviations"), motion)
    check_places(scenario, certificate, robot, motion)
    pairs = pairs_of(scenario, certificate, robot)
    promises = [kind for kind in KINDS if any(limit[0] == kind for limit in limits)]
    promises += [key for key in ("keep", "stand") if option(scenario, key)] + list(pairs)
    require(given("promises") == promises, f"the promises are {promises}")
    intervals, directions = cover(given("intervals"), motion.segments, len(promises))
    tube = number(given("tracking_error"))
    require(tube >= 0.0, "the tracking error is negative")
    check_intervals(scenario, robot, motion, tube, limits, pairs, promises, intervals, directions)
    outcome = "certified in part" if missing else "certified"
    tail = f"; not certified: {', '.join(missing)}" if missing else ""
    proved = ", ".join(["horizon", "ends", *(k for k in ("goal", "waypoints") if option(scenario, k)), *promises])
    ignored = option(option(scenario, "self_collision"), "ignored_pairs", [])
    named = {frozenset(pair) for pair in ignored}
    count = sum(frozenset(pair) not in named for pair in given("may_overlap"))
    if count:
        tail += f"; assumed: {count} pairs of links that the scenario does not name may overlap or never meet"
    within = f" for positions within {tube:g} of the motion" if tube else ""
    return f"{outcome} at all times{within}, by {len(intervals)} intervals: {proved}{tail}"


def main(files):
    try:
        require(len(files) == 4, "usage: python -m aghf.check_certificate ROBOT.urdf SCENARIO SUMMARY CERTIFICATE")
        texts = []
        for file in files:
            with open(file, encoding="utf-8", newline="") as opened:
                texts.append(opened.read())
        print(check(*texts))
    except (OSError, UnicodeError, Refused) as fault:
        print(f"refused: {fault}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
