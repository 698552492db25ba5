"""A checker of certificates, with numpy alone: `python -m aghf.check_certificate ROBOT.urdf SCENARIO SUMMARY
CERTIFICATE [FOLDER ...]`. The exit code is 0 if all promises are proved, 4 if the certificate leaves some out or a mesh
is not read, 1 if it is refused. Packages with meshes are in the folders of the URDF and above it, or in those named.

It shares no code with the library that plans motions and writes certificates: URDF, scenario, polynomials, inverse
dynamics and distances are read and computed here once more, for all intervals at once, with the errors of rounding.
`proofs/certificate_format.md` has what is checked, `proofs/certificate.md` why it proves the promises.
"""

import functools
import hashlib
import itertools
import json
import math
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

import numpy as np

UNIT = 2.0**-53
UP = 1.0 + 1024.0 * UNIT
TINY = 2.0**-1022
SIN_COS = 2.0**-51  # the assumed error of the sine and the cosine of the platform
TOLERANCE, STATE, ACCELERATION = 1e-9, 1e-9, 1e-6
EQUALITY = 1e-6  # the largest deviation of a row that is zero, in its unit
SAME_TIME = 1e-12  # the accepted difference of times, of the horizon: more than rounding
NOT_UNIT = 2e-3  # the largest deviation of the square of the norm of a quaternion from one
LARGEST = 1e6  # the largest length, mass and similar number
LEVELS, DEGREE, BALLS = 127, 100, 10_000  # at most: of lists and objects, of a motion, along links
ORDER = 10
# The radius about a piece of a mesh, m, and the distance of a corner of the mesh from it that is accepted.
RADIUS, ACCEPTED = 1e-6, 0.9e-6
KINDS = ["position", "velocity", "acceleration", "jerk", "torque", "power"]
# The least distance from a limit at which a joint starts outside of it, rad or m.
OUTSIDE = 1e-9
# The distance that such a joint may go further out.
FURTHER = 5e-5


class Refused(Exception):
    """The reason of a refusal."""


# What a certificate proves, in words, and whether nothing that the scenario promises is left out.
Report = NamedTuple("Report", [("text", str), ("is_complete", bool)])


def require(condition, fault):
    if not condition:
        raise Refused(fault)


def real(digits):
    value = float(digits)
    require(math.isfinite(value), f"{digits[:20]} is no finite number")
    return value


def parse(text):
    """The value of a JSON text. Numbers that may be indices are `int`, all others `float`."""

    def whole(digits):
        return int(digits) if digits.isdigit() and len(digits) < 10 else real(digits)

    def members(pairs):
        found = dict(pairs)
        require(len(found) == len(pairs), "a key is repeated in an object")
        return found

    # What is outside of strings: escapes are inside of them in a valid text.
    outside = "".join(re.sub(r"\\.", "", text, flags=re.DOTALL).split('"')[::2])
    steps = (1 if bracket in "[{" else -1 for bracket in re.findall(r"[][{}]", outside))
    require(max(itertools.accumulate(steps), default=0) <= LEVELS, f"lists and objects are more than {LEVELS} deep")
    value = json.loads(text, parse_float=real, parse_int=whole, parse_constant=real, object_pairs_hook=members)
    if re.search(r"\\u[dD][89a-fA-F]", text):
        # Halves of surrogates have no code in UTF-8.
        json.dumps(value, ensure_ascii=False).encode()
    return value


GRAMMAR = parse(Path(__file__).with_name("certificate_grammar.json").read_text(encoding="utf-8"))
# The kinds of numbers in JSON, and in attributes, which have three if the kind is in the plural.
RANGES = {
    "number": lambda x: True,
    "weight": lambda x: x >= 0.0,
    "positive": lambda x: 0.0 < x <= LARGEST,
    "magnitude": lambda x: 0.0 <= x <= LARGEST,
    "length": lambda x: abs(x) <= LARGEST,
    "share": lambda x: 0.0 < x <= 1.0,
    "angle": lambda x: 0.0 < x < math.pi,
    "place": lambda x: abs(x) <= 1.0,
    "reserve": lambda x: -TOLERANCE <= x <= 1.0,
}
DECIMALS = dict(decimal="number", decimal0="weight", decimal1="positive", decimals="length", decimals1="positive")
DECIMAL = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")


def decimals(text):
    """The numbers of an attribute."""
    words = re.findall(r"[^ \t\r\n]+", text)
    require(all(map(DECIMAL.fullmatch, words)), f"'{text}' has something that is no number")
    return [real(word) for word in words]


def is_kind(item, kind):
    """True if an item is of a kind that the notation of the grammar itself has."""
    if kind in RANGES:
        return type(item) in (int, float) and RANGES[kind](item)
    if kind == "index":
        return type(item) is int and item <= LARGEST
    if not isinstance(item, str):
        return kind == "any" or (kind == "bool" and type(item) is bool) or (kind == "null" and item is None)
    if kind in DECIMALS:
        values, count = decimals(item), 3 if kind.startswith("decimals") else 1
        return len(values) == count and all(map(RANGES[DECIMALS[kind]], values))
    if kind == "hash":
        return re.fullmatch("[0-9a-fA-F]{64}", item) is not None
    return kind in ("any", "text", f"'{item}'") or (kind == "name" and item != "")


def fault(item, rule):
    """Where and why a value of JSON, an element or an attribute is not what a rule of the grammar has, or nothing."""
    if isinstance(rule, str):
        if rule in GRAMMAR:
            return fault(item, GRAMMAR[rule])
        is_one = any(not fault(item, name) for name in rule.split("|")) if "|" in rule else is_kind(item, rule)
        return "" if is_one else f": this is no {rule}"
    if isinstance(rule, dict):
        return fault_of_members(item, {name.rstrip("?*"): (name[-1:], rule) for name, rule in rule.items()})
    if not isinstance(item, list) or len(rule) not in (1, len(item)):
        return ": this is no list of this length"
    faults = zip(itertools.count(), map(fault, item, itertools.cycle(rule)))
    return next((f"[{i}]{inner}" for i, inner in faults if inner), "")


def fault_of_members(item, rules):
    """The same of an object or an element, by the ending and the rule of each key."""
    if not isinstance(item, (dict, ElementTree.Element)):
        return ": this is no object"
    given, found = list(item.items()), set()
    if not isinstance(item, dict):
        given = [(f"@{key}", value) for key, value in given] + [(inner.tag, inner) for inner in item]
    for key, value in given:
        ending, rule = rules.get(key) or rules.get("") or ("", None)
        if rule is None or (key in found and ending != "*"):
            return f": '{key}' is {'there twice' if rule else 'not in the subset'}"
        found.add(key)
        inner = fault(value, rule)
        if inner:
            return f".{key}{inner}"
    missing = [name for name, (ending, _) in rules.items() if name not in found and ending not in "?*"]
    return f": {missing} are missing" if missing else ""


def accept(item, rule):
    """Refuses an item that is not what this rule of the grammar has."""
    found = fault(item, rule)
    require(not found, f"{rule}{found}")


def read(text, rule):
    """The value of a JSON text that is what this rule of the grammar has."""
    try:
        value = parse(text)
    except (Refused, ValueError) as error:
        raise Refused(f"{rule}: {error}") from error
    accept(value, rule)
    return value


class Elements(ElementTree.TreeBuilder):
    """The elements of an XML text."""

    def pi(self, *_):
        raise Refused("the robot has a document type declaration or a processing instruction")

    doctype = pi


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


def option(value, key, default=None):
    """The value of a key of an object or, of anything else, the default."""
    found = value.get(key) if isinstance(value, dict) else None
    return default if found is None else found


def entries(value, key):
    """The entries of a list, a single value that is not a list, or nothing."""
    found = option(value, key, [])
    return found if isinstance(found, list) else [found]


def joint_values(value, key, count):
    """A number for each joint, zero by default."""
    found = option(value, key, [0.0] * count)
    require(len(found) == count, f"{key} has {len(found)} entries, not {count}")
    return found


def attribute(node, name, default=(0.0,)):
    """The numbers of an attribute of an element."""
    text = None if node is None else node.get(name)
    return default if text is None else decimals(text)


def pose(node):
    roll = attribute(node, "rpy", [0.0, 0.0, 0.0])
    x, y, z = (about(IDENTITY[0][i], *Model.constant([roll[i]]).sin_cos()) for i in range(3))
    return product(z, product(y, x)), vector(attribute(node, "xyz", [0.0, 0.0, 0.0]))


def quaternion(value):
    if value is None:
        return IDENTITY[0]
    require(abs(sum(x * x for x in value) - 1.0) <= NOT_UNIT, "an orientation is no unit quaternion")
    q = Model.constant(np.array(value).reshape(4, 1))
    norm = functools.reduce(Model.__add__, (x * x for x in (q[0], q[1], q[2], q[3]))).inverse_sqrt()
    x, y, z, w = (q[i] * norm for i in range(4))
    two, one = x.like(2.0), x.like(1.0)
    return stack([
        stack([one - two * (y * y + z * z), two * (x * y - z * w), two * (x * z + y * w)]),
        stack([two * (x * y + z * w), one - two * (x * x + z * z), two * (y * z - x * w)]),
        stack([two * (x * z - y * w), two * (y * z + x * w), one - two * (x * x + y * y)]),
    ])


def pose_of(value):
    return quaternion(option(value, "orientation_xyzw")), vector(value["position_m"])


def solid_of(shape):
    """The kind of an obstacle or a load and its lengths."""
    ((kind, own),) = shape.items()
    if kind == "box":
        return kind, [0.5 * x for x in own["size_m"]]
    return kind, [option(own, "radius_m", 0.0), 0.5 * option(own, "length_m", 0.0)]


class Joint:
    """A joint and its body, in the frame of the joint."""

    def __init__(self, node, parent, origin):
        self.name, self.parent, self.origin = node.get("name"), parent, origin
        self.slides = node.get("type") == "prismatic"
        self.axis = unit(attribute(node.find("axis"), "xyz", [1.0, 0.0, 0.0]))
        self.mass, self.first = Model.constant([0.0]), vector([0.0, 0.0, 0.0])
        self.inertia = Model.constant(np.zeros((3, 3, 1)))
        self.drive, self.limits = [Model.constant([0.0])] * 4, [-math.inf, math.inf, math.inf, math.inf]

    def read(self, node, scenario):
        is_free = node.find("mimic") is None or option(scenario, "mimic") == "independent"
        require(is_free, f"joint '{self.name}' mimics another one")
        limits = [attribute(node.find("limit"), key)[0] for key in ("lower", "upper", "velocity", "effort")]
        if any(limits):
            require(limits[0] <= limits[1], f"the limits of joint '{self.name}' exclude all positions")
            self.limits = limits[:2] + [x if x > 0.0 else math.inf for x in limits[2:]]
            if node.get("type") == "continuous":
                self.limits[:2] = [-math.inf, math.inf]
        losses = option(scenario, "losses", False)
        if losses is False:
            return

        def given(key, default):
            found = option(losses, key, default)
            return option(found, self.name, default) if isinstance(found, dict) else found

        damping, friction = (attribute(node.find("dynamics"), key)[0] for key in ("damping", "friction"))
        drive = [given("damping", damping), given("friction", friction), 1.0, given("armature", 0.0)]
        self.drive = [Model.constant([x]) for x in drive]
        self.drive[2] = self.drive[2].over(given("friction_velocity", 0.02))

    def placement(self, q):
        if self.slides:
            return self.origin[0], self.origin[1] + apply(self.origin[0], self.axis * q[np.newaxis])
        return product(self.origin[0], about(self.axis, *q.sin_cos())), self.origin[1]


def triangles(name, data):
    """The corners of the triangles of an STL or OBJ, number by 3 by 3; `None` if the file has another format or more
    than is read here."""
    name = name.strip().lower()
    if name.endswith(".stl") and len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        rows = np.frombuffer(data[84:], dtype=np.uint8).reshape(-1, 50)[:, 12:48]
        return rows.copy().view("<f4").astype(float).reshape(-1, 3, 3)
    corners, found = [], []
    is_stl = name.endswith(".stl")
    passed = "solid facet outer endloop endfacet endsolid" if is_stl else "vn vt vp o g s l p usemtl mtllib"
    try:
        for line in data.decode().splitlines() if is_stl or name.endswith(".obj") else ["?"]:
            word, *rest = line.split() or [passed.split()[0]]
            if word == ("vertex" if is_stl else "v"):
                corners.append([real(x) for x in rest[:3]])
                require(len(corners[-1]) == 3, "a corner has no three numbers")
            elif word == "f" and not is_stl:
                own = [int(x.split("/")[0]) for x in rest]
                own = [i - 1 if i > 0 else len(corners) + i for i in own]
                require(all(0 <= i < len(corners) for i in own), "a face has an unknown corner")
                found += [[corners[own[0]], corners[own[i - 1]], corners[own[i]]] for i in range(2, len(own))]
            elif word not in passed.split() and (word[0] != "#" or is_stl):
                return None
    except (Refused, ValueError):
        return None
    if is_stl:
        return np.array(corners).reshape(-1, 3, 3) if len(corners) % 3 == 0 else None
    return np.array(found).reshape(-1, 3, 3)


def are_inside(points, piece):
    """True where a point is within `ACCEPTED` of an average of corners: of their middle and those of a face."""
    corners, faces = piece
    middle = corners.mean(axis=0)
    ways = corners[faces] - middle
    a, b, c = ways[:, 0], ways[:, 1], ways[:, 2]
    normals = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    normals = normals / (a * normals[:, 0]).sum(axis=1)[:, None, None]
    found = (points[:, None] == corners).all(axis=2).any(axis=1)
    points = points - middle
    for face, weights in zip(ways, normals):
        (left,) = np.nonzero(~found)
        share = np.nan_to_num(np.maximum(points[left] @ weights.T, 0.0), posinf=0.0)
        share /= np.maximum(share.sum(axis=1), 1.0)[:, None]
        off = points[left] - share @ face
        slack = ACCEPTED - 64.0 * UNIT * np.sqrt((points[left] ** 2).sum(axis=1))
        found[left[np.sqrt((off**2).sum(axis=1)) <= slack]] = True
    return found


def read_piece(corners, faces):
    """The corners and the faces of a piece of a mesh."""
    require(corners and all(i < len(corners) for face in faces for i in face), "a piece of a mesh has a wrong face")
    return np.array(corners, dtype=float), np.array(faces, dtype=int).reshape(-1, 3)


def check_meshes(robot, pieces, listed, files):
    """Checks that pieces contain their meshes, and returns the names of those that are not read."""
    require(set(listed) == {name for name, _ in robot.meshes}, "the meshes are not those of the robot")
    data = {name: files(name) for name in listed}
    for name, found in data.items():
        is_same = found is None or hashlib.sha256(found).hexdigest() == listed[name]
        require(is_same, f"'{name}' is another file than that of the certificate")
    known = {name: None if found is None else triangles(name, found) for name, found in data.items()}
    for (name, scale), own in zip(robot.meshes, pieces):
        if known[name] is not None:
            all_points, of = np.unique(known[name].reshape(-1, 3) * scale, axis=0, return_inverse=True)
            inside = [are_inside(all_points, piece)[of.reshape(-1, 3)].all(axis=1) for piece in own]
            require(np.any(inside, axis=0).all(), f"the pieces of '{name}' do not contain it")
    return sorted(name for name, found in known.items() if found is None)


def find_mesh(name, robot, folders=()):
    """The bytes of the mesh that a URDF calls so: a path from its folder, or `package://NAME/PATH`, which is looked up
    in the folder of the URDF, in those above it and in `folders`; `None` if there is no such file."""
    own, name = Path(robot).absolute().parent, name.strip()
    files = [own / name.removeprefix("file://")]
    if name.startswith("package://"):
        package, _, path = name.removeprefix("package://").lstrip("/").partition("/")
        files = []
        for folder in [own, *own.parents, *map(Path, folders)]:
            files += [folder / package / path] + ([folder / path] if folder.name == package else [])
    return next((file.read_bytes() for file in files if file.is_file()), None)


class Robot:
    """The moving bodies of a URDF and the shapes that keep clear."""

    def __init__(self, urdf, scenario, names, pieces):
        urdf = urdf.partition("?>")[2] if urdf.startswith("<?xml ") else urdf
        require("&#" not in urdf and urdf[:1] != "\ufeff", "the robot has a reference to a number or a byte order mark")
        root = ElementTree.fromstring(urdf, ElementTree.XMLParser(target=Elements()))
        require(root.tag == "robot", "it is no 'robot'")
        accept(root, "robot")
        links = {link.get("name"): link for link in root.findall("link")}
        placed = self.add_joints(root, links, scenario, names)
        self.base, self.links = (Model.constant([0.0]), vector([0.0] * 3)), placed
        self.gravity = option(scenario, "gravity", [0.0, 0.0, -9.81])
        for link, (body, at) in placed.items():
            inertial = links[link].find("inertial")
            if inertial is not None:
                six = [attribute(inertial.find("inertia"), f"i{k}")[0] for k in ("xx", "xy", "xz", "yy", "yz", "zz")]
                mass = attribute(inertial.find("mass"), "value")[0]
                self.add_mass(body, compose(at, pose(inertial.find("origin"))), mass, six)
        load = option(scenario, "payload")
        if load is not None:
            body, at = placed.get(load["link"], (None, None))
            require(body is not None, "the payload is on no link that moves")
            center = (IDENTITY[0], vector(option(load, "center_m", [0.0] * 3)))
            self.add_mass(body, compose(at, center), load["mass_kg"], option(load, "inertia_kg_m2", [0.0] * 6))
        # Per shape the body, the link, the placement, the kind and the lengths: of a piece of a mesh the radius of a
        # ball and the corners. Per mesh the name and the scale.
        self.parts, self.is_known, self.meshes = [], True, []
        is_shaped = any(link.find("collision") is not None for link in links.values())
        shape = option(scenario, "robot_shape", {"collision": {}} if is_shaped else "joint_frames")
        self.has_links = option(shape, "collision") is not None
        if self.has_links:
            self.add_shapes(links, pieces)
        elif shape == "joint_frames":
            self.parts += [(body, "", IDENTITY, "sphere", [0.0]) for body in range(len(self.joints))]
        else:
            self.add_swept(shape["swept_links"])
        if option(load, "shape") is not None:
            kind, size = solid_of(load["shape"])
            default = {"position_m": option(load, "center_m", [0.0] * 3)}
            self.is_known &= self.has_links or kind == "sphere"
            at = compose(placed[load["link"]][1], pose_of(option(load, "shape_pose", default)))
            self.parts.append((body, load["link"], at, kind, size))
        require(len(self.meshes) == len(pieces), "there are pieces of other meshes than those of the robot")
        self.has_balls = self.is_known and all(kind == "sphere" for _, _, _, kind, _ in self.parts)

    def add_joints(self, root, links, scenario, names):
        """Reads the joints, and returns the body of each link and its placement in it."""
        all_joints = root.findall("joint")
        ends = [[joint.find(end).get("link") for end in ("parent", "child")] for joint in all_joints]
        is_unique = len({joint.get("name") for joint in all_joints}) == len(all_joints)
        require(is_unique and len(links) == len(root.findall("link")), "two links or two joints have the same name")
        carried = {child for _, child in ends}
        is_tree = len(carried) == len(ends) == len(links) - 1 and {link for pair in ends for link in pair} <= set(links)
        require(is_tree, "links and joints are no tree")
        (base,) = set(links) - carried
        base, locks = option(scenario, "root", base), option(scenario, "locked_joints", {})
        require(base in links, "the robot has no such root")
        joints, placed = {}, {}
        opened = [(base, None, pose_of(scenario["mount"]) if "mount" in scenario else IDENTITY, None)]
        while opened:
            link, body, at, before = opened.pop()
            require(link not in placed, "links form a loop")
            placed[link] = (body, at)
            for node, pair in zip(all_joints, ends):
                if node is before or link not in pair:
                    continue
                turned = link == pair[1]
                # From a new root some joints are met from their other side: they turn back, and then comes the origin.
                step = pose(node.find("origin"))
                origin, then = (at, inverse(step)) if turned else (compose(at, step), IDENTITY)
                beyond, kind = pair[0 if turned else 1], node.get("type")
                joint = Joint(node, body, origin)
                if turned:
                    joint.axis = -joint.axis
                if kind == "fixed":
                    opened.append((beyond, body, compose(origin, then), node))
                elif joint.name in locks:
                    placement = joint.placement(Model.constant([locks[joint.name]]))
                    opened.append((beyond, body, compose(placement, then), node))
                else:
                    require(joint.name in names, f"joint '{joint.name}' has no motion")
                    joint.read(node, scenario)
                    i = names.index(joint.name)
                    joints[i] = joint
                    opened.append((beyond, i, then, node))
        require(len(placed) == len(links), "links form a loop")
        known = {joint.get("name") for joint in all_joints} - set(names)
        require(set(locks) <= known, "a locked joint is unknown, or moves")
        require(len(joints) == len(names), "the motion has a joint that the robot has not")
        self.joints = [joints[i] for i in range(len(names))]
        early = all(joint.parent is None or joint.parent < i for i, joint in enumerate(self.joints))
        require(early, "a joint is before its parent")
        return placed

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

    def add_shapes(self, links, pieces):
        """Adds the collision elements, by the names of their links, meshes as their pieces."""
        for link, (body, at) in sorted(self.links.items()):
            for collision in links[link].findall("collision"):
                (own,) = collision.find("geometry")
                if own.tag == "mesh":
                    known = pieces[len(self.meshes) : len(self.meshes) + 1] or [[]]
                    require(known[0], f"a mesh of link '{link}' has no pieces")
                    for corners, _ in known[0]:
                        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
                        centre = compose(compose(at, pose(collision.find("origin"))), (IDENTITY[0], vector(middle)))
                        corners = corners - middle
                        radius = np.sqrt((corners**2).sum(axis=1).max()) * (1.0 + 8.0 * UNIT) + RADIUS
                        self.parts.append((body, link, centre, "piece", [radius, corners]))
                    self.meshes.append((own.get("filename"), attribute(own, "scale", (1.0, 1.0, 1.0))))
                    continue
                size = [attribute(own, "radius")[0], 0.5 * attribute(own, "length")[0]]
                if own.tag == "box":
                    size = [0.5 * x for x in attribute(own, "size")]
                self.parts.append((body, link, compose(at, pose(collision.find("origin"))), own.tag, size))

    def add_swept(self, swept):
        """Adds balls from the origin of each body to the frames that it carries."""
        spacing = option(swept, "spacing_m", 0.05)
        for body in range(len(self.joints)):
            ends = [joint.origin[1] for joint in self.joints if joint.parent == body]
            ends += [at[1] for of, at in self.links.values() if of == body]
            lengths = [math.sqrt(float((end.c[0] ** 2).sum())) for end in ends]
            for end, length in [x for x in zip(ends, lengths) if x[1] > 0.0] or [(vector([0.0] * 3), 0.0)]:
                pieces = max(float(np.ceil(length / spacing)), 1.0)
                require(len(self.parts) + pieces < BALLS, f"the robot has more than {BALLS} balls")
                radius = math.hypot(swept["radius_m"], 0.5 * length / pieces)
                for i in range(int(pieces) + 1):
                    at = IDENTITY[0], end * Model.constant(float(i)).over(pieces)
                    self.parts.append((body, "", at, "sphere", [radius]))

    def torques(self, q, v, a):
        """Inverse dynamics by the recursive Newton-Euler algorithm in the frames of the joints: the torques, and the
        force on the base and its moment about the origin."""
        zero, gravity = vector([0.0] * 3), vector([-x for x in self.gravity])
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
        mass = sum(joint.mass.c[0].item() for joint in self.joints) + self.base[0].c[0].item()
        return math.hypot(*self.gravity) * mass

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
        """The placement of a link and its body."""
        require(name in self.robot.links, f"there is no link '{name}'")
        body, at = self.robot.links[name]
        return (at if body is None else compose(self.places[body], at)), body

    def poses(self, goal):
        """The rows of a set of poses."""
        turn, at = self.link(goal["frame"])[0]
        if "relative_to" in goal:
            other = self.link(goal["relative_to"])[0]
            turn, at = product(transpose(other[0]), turn), apply(transpose(other[0]), at - other[1])
        has_turn = "orientation_xyzw" in goal or "axis" in goal
        is_double = {"position_m", "box"} <= set(goal) or {"orientation_xyzw", "axis"} <= set(goal)
        is_of = ("tolerance_m" not in goal or "position_m" in goal) and ("tolerance_rad" not in goal or has_turn)
        require(is_of and not is_double, "poses have a tolerance of nothing, or two conditions of a kind")
        rows = []
        if "position_m" in goal:
            off, r = at - vector(goal["position_m"]), option(goal, "tolerance_m")
            if r is None:
                rows += [zero("position", off[i]) for i in range(3)]
            else:
                square = dot(off, off)
                rows.append(most("distance", square - square.like(r) * square.like(r), 2.0 * r))
        if "box" in goal:
            centre = pose_of(goal["box"]["pose"])
            off = apply(transpose(centre[0]), at - centre[1])
            for i, size in enumerate(goal["box"]["size_m"]):
                if size is not None:
                    # Half of the least number is zero.
                    half = 0.5 * size
                    inside = "position in a box", off[i], [-half, half], 1.0
                    rows.append(inside if half > 0.0 else zero("position", off[i]))
        within = option(goal, "tolerance_rad")
        if "orientation_xyzw" in goal:
            m = product(transpose(quaternion(goal["orientation_xyzw"])), turn)
            sine = stack([(m[i, j] - m[j, i]).over(2.0) for i, j in ((2, 1), (0, 2), (1, 0))])
            rows += angle(sine, (m[0, 0] + m[1, 1] + m[2, 2] - m[0, 0].like(1.0)).over(2.0), within)
        elif "axis" in goal:
            own, aim = (unit(goal["axis"][key]) for key in ("of_frame", "direction"))
            own = apply(turn, own)
            rows += angle(cross(own, aim), dot(own, aim), within)
        require(rows, "poses have no condition")
        return rows

    def kept(self, condition):
        """The rows of a condition along the way."""
        require(("poses" in condition) != ("speed" in condition), "one of poses and speed is kept")
        if "poses" in condition:
            return self.poses(condition["poses"])
        of = condition["speed"]
        (turn, at), body = self.link(of["frame"])
        point = apply(turn, vector(option(of, "point_m", [0.0] * 3))) + at
        velocity = vector([0.0] * 3)
        while body is not None:
            joint, (turn, at) = self.robot.joints[body], self.places[body]
            axis = apply(turn, joint.axis)
            velocity = velocity + (axis if joint.slides else cross(axis, point - at)) * self.v[body]
            body = joint.parent
        square, bound = dot(velocity, velocity), of["most_m_s"]
        return [most("speed", square - square.like(bound) * square.like(bound), 2.0 * bound)]

    def waypoint(self, point):
        """The rows of a waypoint."""
        require(("poses" in point) != ("q" in point), "a waypoint is one of q and poses")
        rows = self.poses(point["poses"]) if "poses" in point else []
        if "q" in point:
            aims = joint_values(point, "q", len(self.robot.joints))
            rows += [zero("position", self.q[i] - self.q[i].like(aim)) for i, aim in enumerate(aims)]
        if option(point, "stop", False):
            rows += [zero("velocity", self.v[i]) for i in range(len(self.robot.joints))]
        return rows

    def foot(self, stand, force, moment):
        """The rows of a standing foot under the force of the ground on the base and its moment."""
        (turn, at), body = self.link(stand["frame"])
        require(body is None, "the foot moves")
        if "sole" in stand:
            turn, at = compose((turn, at), pose_of(stand["sole"]))
        force, moment = apply(transpose(turn), force), apply(transpose(turn), moment - cross(at, force))
        up, weight, friction = force[2], self.robot.weight(), stand["friction"]
        rows = [most("normal force", -up, weight)]
        for i, key in ((1, "half_length_m"), (0, "half_width_m"), (2, "torsion")):
            if key in stand:
                side = up * up.like(stand[key])
                rows += [most(key, moment[i] - side, weight), most(key, -moment[i] - side, weight)]
        bound = up * up.like(friction)
        slip = (force[0] * force[0] + force[1] * force[1] - bound * bound).over(2.0 * friction)
        return [*rows, most("friction", slip, weight * weight)]


def most(name, x, scale):
    return name, x, [-math.inf, 0.0], scale


def zero(name, x):
    return name, x, [-EQUALITY, EQUALITY], 1.0


def angle(sine, cosine, within):
    """The rows of an angle with this sine, times an axis, and cosine, at most a bound or, without one, zero."""
    bound = math.pi / 3.0 if within is None else within
    rows = [most("angle", cosine.like(math.cos(bound)) - cosine, math.sin(bound))]
    return rows + ([zero("angle", sine[i]) for i in range(3)] if within is None else [])


def unit(axis):
    axis = vector(axis)
    return axis * dot(axis, axis).inverse_sqrt()[np.newaxis]


def ball(x):
    return Model.constant(x, order=1)


def sums(a, b):
    """The product of matrices of numbers, whose terms are added in any order."""
    x, y, n = np.abs(a.c[0]), np.abs(b.c[0]), a.r.shape[-1]
    radius = x @ b.r + a.r @ (y + b.r) + (n + 2) * UNIT * (x @ y)
    return Model((a.c[0] @ b.c[0])[np.newaxis], radius * UP + TINY)


def derivative(n):
    """The matrix from the Chebyshev coefficients of a polynomial of degree n to those of its derivative: 2 j from each
    j to all k that are smaller by an odd number, with half of it for k = 0."""
    j, k = np.arange(n + 1.0)[:, np.newaxis], np.arange(float(n))
    return ball(np.where((j > k) & ((j - k) % 2.0 == 1.0), np.where(k == 0.0, 1.0, 2.0) * j, 0.0))


class Motion:
    """The piecewise polynomial motion of a run: its positions, whose rates are the velocities of the run."""

    def __init__(self, curve):
        self.horizon, self.segments = curve["horizon_s"], len(curve["coefficients"])
        joints, degree = len(curve["joints"]), curve["degree"]
        require(degree <= DEGREE, f"the degree of the motion is above {DEGREE}")
        lengths = {(len(segment), len(row)) for segment in curve["coefficients"] for row in segment or [[]]}
        is_whole = lengths == {(2 * joints, degree + 1)} and min(joints, degree) > 0
        require(is_whole and curve["segments"] == self.segments, "the coefficients are not those of the joints")
        c = ball(np.array(curve["coefficients"], dtype=float))
        # Per order the derivatives of the positions over factorials: segments by joints by coefficients.
        self.taylor, velocities = [c[:, :joints]], c[:, joints:]
        for k in range(degree):
            self.taylor.append(sums(self.taylor[-1], derivative(degree - k)).over(k + 1.0))
        rates = self.taylor[1] * ball(2.0 * self.segments).over(self.horizon)
        off = (velocities[..., :-1] - rates).most().sum(axis=-1) + velocities[..., -1].most()
        require(np.all(off * UP <= STATE), "a velocity of the run is not the rate of the position")

    def time(self, segment, x):
        """The time of a place, s, with an error of less than 1e-15 of the horizon."""
        return (segment + 0.5 * (1.0 + x)) * self.horizon / self.segments

    def states(self, robot, segment, x):
        """The states at a place."""
        own = self.expand([segment], np.array([x]), np.array([2.0**-20]))[:2]
        return States(robot, *(Model.constant(part.c[0]).widened(part.r) for part in own))

    def expand(self, own, middles, halves):
        """Positions, velocities, accelerations and jerks of the joints on parts |x - m| <= w of segments: coefficients
        and bounds on errors, by Taylor coefficients about m from the Chebyshev coefficients of the derivatives."""
        count, one, x, w = len(middles), ball(np.ones(len(middles))), ball(middles), ball(halves)
        n, joints = len(self.taylor), self.taylor[0].r.shape[1]
        chebyshev, powers = [one, x], itertools.accumulate([one] + [w] * (n - 1), Model.__mul__)
        for j in range(2, n):
            twice = chebyshev[j // 2] * chebyshev[j - j // 2] * ball(2.0)
            chebyshev.append(twice - (x if j % 2 else one))
        chebyshev, taylor = stack(chebyshev), ball(np.zeros((n, joints, count)))
        for segment in set(own):
            at = np.flatnonzero(np.equal(own, segment))
            for k, part in enumerate(self.taylor):
                found = sums(part[segment], chebyshev[: n - k, at])
                taylor.c[0, k][:, at], taylor.r[k][:, at] = found.c[0], found.r
        taylor = taylor * stack(list(powers))[:, np.newaxis]
        rate = ball(np.full(count, 2.0 * self.segments)).over(self.horizon).over(halves)
        found = []
        for order in range(4):
            found.append(Model(taylor.c[0], taylor.r.sum(axis=0) * UP))
            # A derivative beyond the degree is zero.
            k = np.arange(1.0, n - order).reshape(-1, 1, 1) if order + 1 < n else np.zeros((1, 1, 1))
            taylor = taylor[-len(k) :] * ball(k) * rate
        return found


def cut(polynomials):
    """The polynomials with ORDER coefficients."""
    c = polynomials.c
    kept = np.concatenate([c[:ORDER], np.zeros((max(ORDER - len(c), 0), *c.shape[1:]))])
    return Model(kept, polynomials.r).widened(np.abs(c[ORDER:]).sum(axis=0) * UP)


@functools.lru_cache
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
    """The limits that a scenario enforces: promise, joint, bounds, and the time from which on they are kept."""
    enforced, passive = option(scenario, "enforced_limits", {}), option(scenario, "passive", [])
    names = [joint.name for joint in robot.joints]
    named = passive + [name for part in enforced.values() for name in option(part, "joints", [])]
    require(set(named) <= set(names), "a joint of the limits or a passive joint is unknown")
    lists = [part for part in enforced.values() if isinstance(part, list)]
    require(all(len(part) == len(names) for part in lists), "a list of limits is of another number of joints")

    def share(key, joint):
        found = option(enforced, key, True)
        if isinstance(found, dict):
            found = option(found, "share", 1.0) if joint in option(found, "joints", [joint]) else False
        return None if found is False else 1.0 if found is True else found

    limits = []
    for promise in KINDS:
        most = option(enforced, "max_velocity" if promise == "velocity" else promise)
        for i, joint in enumerate(robot.joints):
            lower, upper, velocity, effort = joint.limits
            part, bounds = share(promise, joint.name), [-math.inf, math.inf]
            if promise == "position" and part is not None:
                cut_off = 0.5 * (1.0 - part) * (upper - lower)
                bounds = [lower + cut_off, upper - cut_off] if math.isfinite(cut_off) else [lower, upper]
            elif promise == "velocity" and part is not None:
                bounds = [-part * velocity, part * velocity]
            elif promise == "torque" and part is not None and joint.name not in passive:
                bounds = [-part * effort, part * effort]
            given = most[i] if isinstance(most, list) else most
            if promise in ("velocity", "acceleration", "jerk", "power") and given is not None:
                bounds = [max(bounds[0], -given), min(bounds[1], given)]
            from_s, start = -math.inf, joint_values(scenario, "q_start", len(names))[i]
            tolerance, off = option(scenario, "start_tolerance"), max(bounds[0] - start, start - bounds[1])
            if promise == "position" and tolerance is not None:
                if OUTSIDE < off <= option(tolerance, "position", 1e-4):
                    around = [min(bounds[0], start - FURTHER), max(bounds[1], start + FURTHER)]
                    limits.append((promise, i, around, from_s))
                    from_s = option(tolerance, "back_s", 0.25)
            if any(map(math.isfinite, bounds)):
                limits.append((promise, i, bounds, from_s))
    return limits


def clearance(scenario, key):
    """The distance that the scenario keeps from obstacles or between links."""
    given = option(scenario, "clearance_m", 0.0)
    return option(given, key, 0.0) if isinstance(given, dict) else given


def obstacles_of(scenario):
    """The obstacles: placement, kind, lengths, and the distance that is kept."""
    kept = clearance(scenario, "obstacles")
    return [
        (pose_of(obstacle["pose"]), *solid_of(obstacle["shape"]), option(obstacle, "clearance_m", kept))
        for obstacle in option(scenario, "obstacles", [])
    ]


def lower(x):
    return least(x, np.inf, 1e-12)


def length(vectors):
    """Lower bounds on the lengths of vectors, a list of lists of coordinates."""
    square = functools.reduce(Model.__add__, (x * x for x in vectors))
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


def link_pairs(listed, robot):
    """Pairs of different links, each once."""
    found = [frozenset(pair) for pair in listed]
    known = all(len(pair) == 2 and pair <= set(robot.links) for pair in found)
    require(known and len(set(found)) == len(found), "a pair is not of two links, or is there twice")
    return found


def pairs_of(scenario, robot):
    """Per promise the pairs of a shape, an obstacle or another shape, and the distance that is kept."""
    obstacles, itself, kept = obstacles_of(scenario), clearance(scenario, "itself"), option(scenario, "self_collision")
    listed = option(option(scenario, "clearance_m"), "pairs", [])
    own = dict(zip(link_pairs((pair["links"] for pair in listed), robot), (pair["clearance_m"] for pair in listed)))
    ignored = option(kept, "ignored_pairs")
    require(robot.has_links or ignored is None, "only links with collision elements are told apart")
    ignored = None if ignored is None else set(link_pairs(ignored, robot))
    if not robot.is_known:
        return {}
    parents = {(i, joint.parent) for i, joint in enumerate(robot.joints)}
    found = {"obstacles": [], "self_collision": []}
    for i, (body, link, *_) in enumerate(robot.parts):
        if body is not None:
            found["obstacles"] += [(i, o, obstacle[3]) for o, obstacle in enumerate(obstacles)]
        for j, (other, beside, *_) in enumerate(robot.parts[i + 1 :], i + 1):
            names = frozenset((link, beside))
            may_overlap = {(body, other), (other, body)} & parents if ignored is None else names in ignored
            if robot.has_links and kept != "off" and link != beside and body != other and not may_overlap:
                found["self_collision"].append((i, j, own.get(names, itself)))
    return {promise: pairs for promise, pairs in found.items() if pairs}


def proved(row, claims):
    """True where a row keeps its bounds and the claims beyond them."""
    _, value, bounds, scale = row
    good = np.full(claims.shape, scale > 0.0)
    # What does not move has one value for all intervals.
    value = value + Model.constant(np.zeros(claims.shape), order=len(value.c))
    for sign, bound in ((1.0, bounds[0]), (-1.0, -bounds[1])):
        if bound != -math.inf:
            wanted = bound + claims * scale
            good &= np.isfinite(wanted)
            good &= least(Model(sign * value.c, value.r), wanted, 1e-13 * scale) >= wanted
    return good


def check_places(scenario, certificate, robot, motion):
    """Checks the claims on the goal, if it is a set of poses, and on the waypoints."""

    def fault(rows, claim):
        """The first row that is not proved."""
        return next((row[0] for row in rows if not np.all(proved(row, np.array([claim])))), None)

    goals = entries(scenario, "goal")
    if goals:
        require("goal" in certificate, "'goal' is missing")
        end = motion.states(robot, motion.segments - 1, 1.0)
        faults = [fault(end.poses(goal), certificate["goal"]) for goal in goals]
        require(None in faults, "the goal is not proved")
    points, places = option(scenario, "waypoints", []), certificate["waypoints"]
    require(len(points) == len(places), "the waypoints are not those of the scenario")
    before = [0, -1.0]
    for i, (point, (segment, x, claim)) in enumerate(zip(points, places)):
        require(segment < motion.segments, f"waypoint {i}: the place is not in the motion")
        wrong = fault(motion.states(robot, segment, x).waypoint(point), claim)
        require(wrong is None, f"waypoint {i}: {wrong} is not proved")
        time = motion.time(segment, x)
        is_then = abs(time - option(point, "time_s", time)) <= SAME_TIME * motion.horizon
        require(is_then, f"waypoint {i}: it has another time")
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


def radius_about(kind, size):
    """The radius of a ball about the centre of a shape that contains it."""
    if kind == "half_space":
        return math.inf
    if kind in ("sphere", "piece"):
        return size[0]
    if kind == "capsule":
        return size[0] + size[1]
    return math.sqrt(sum(x * x for x in size[: 3 if kind == "box" else 2])) * (1.0 + 8.0 * UNIT)


def least_of(gap, ways):
    """Lower bounds on the least of the sums of gaps, a list of them, and ways, a list for each of several corners."""
    x = ways + gap
    low, high = x.c[0] - x.variation(), (x.c[0] + x.variation()).min(axis=0)
    near = ~(low > high)
    found = np.full(near.shape[1], np.inf)
    np.minimum.at(found, np.nonzero(near)[1], lower(Model(x.c[:, near], x.r[near])))
    return found


def gap_along(a, b, n):
    """Lower bounds on the gaps between two shapes along directions from one to the other."""
    gap, ways = dot(n, b[0][1] - a[0][1]), []
    for (at, kind, size), towards in ((a, -n), (b, n)):
        if kind != "piece":
            gap = gap - extent(at, kind, size, n)
            continue
        # The way of each corner from the centre of its piece towards the other shape.
        along, corners = apply(transpose(at[0]), towards), size[1]
        along = Model(along.c + np.zeros(n.c.shape), along.r + np.zeros(n.r.shape))
        c = np.einsum("ci,oik->ock", corners, along.c)
        r = (np.abs(corners) @ (along.r + 8.0 * UNIT * along.size())) * UP + TINY
        ways.append(Model(c, r))
        gap = gap - gap.like(RADIUS * np.sqrt(dot(n, n).most()) * (1.0 + 4.0 * UNIT))
    gap = Model(gap.c + np.zeros((1, n.c.shape[2])), gap.r + np.zeros(n.c.shape[2]))
    if not ways:
        return lower(gap)
    passing = 0.0
    if len(ways) == 2:
        # The corner that is nearest in the middle stands for those of a piece, less the way by which others pass it.
        first, k = ways[0], np.arange(n.c.shape[2])
        nearest = first[first.c[0].argmin(axis=0), k]
        gap, passing = gap + nearest, least_of(-nearest, first)
    return least_of(gap, ways[-1]) + passing


def check_shapes(promise, pairs, claims, robot, obstacles, placed, directions, refuse):
    """Checks that balls or directions separate all pairs by their distances and the claims beyond them."""

    def length(x):
        return np.sqrt((x * x).sum(axis=0))

    for i, j, margin in pairs:
        a, is_part = (placed[i], *robot.parts[i][3:]), promise != "obstacles"
        b, key = ((placed[j], *robot.parts[j][3:]), j) if is_part else (obstacles[j][:3], len(placed) + j)
        still = Model.constant(np.zeros((3, len(claims))))
        off = b[0][1] - a[0][1] + still
        apart = length(off.c[0]) * (1.0 - 24.0 * UNIT) - length(off.variation()) * (1.0 + 8.0 * UNIT)
        is_left = ~(apart - radius_about(*a[1:]) - radius_about(*b[1:]) >= claims + margin)
        if not is_left.any():
            continue
        if b[1] == "half_space":
            n = -transpose(b[0][0])[2] + still
        else:
            n = Model.constant(off.c[0])
            for k, direction in directions.get((i, key), []):
                n.c[0, :, k] = direction
        (left,) = np.nonzero(is_left)
        a, b = (((rotated[:, :, some], moved[:, some]), *rest) for (rotated, moved), *rest, some in chosen(a, b, left))
        n = n[:, left]
        square = dot(n, n)
        good = gap_along(a, b, n) >= (claims[left] + margin) * np.sqrt(square.most()) * (1.0 + 4.0 * UNIT)
        good &= (square.c[0] > 1e-6) & np.isfinite(square.most())
        refuse(promise, left[~good])


def chosen(a, b, left):
    """Two shapes, and which of the intervals are left of each: that does not move has one placement for all."""
    return [(*shape, left if shape[0][1].c.shape[2] > 1 else slice(None)) for shape in (a, b)]


def check_balls(promise, pairs, claims, robot, obstacles, placed, refuse):
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
        i, j, margin = (np.repeat(column, count) for column in zip(*group))
        k = np.tile(np.arange(count), len(group))
        way = ways[i, k] + (0.0 if promise == "obstacles" else ways[j, k])
        # The distance in the middle less the ways from there is enough for most.
        is_left = ~prove((i, k), beside, margin, middles, middles, j, way)
        i, j, k, margin = i[is_left], j[is_left], k[is_left], margin[is_left]
        if len(i):
            good = prove((i, k), beside, margin, centres, centres, j, 0.0)
            refuse(promise, k[~good])


def check_ends(scenario, motion):
    """Checks the states at the ends, accelerations that are given or zero at rest there, and continuity."""
    every, short = np.arange(motion.segments), np.full(motion.segments, 2.0**-20)
    # Short intervals about both ends of each segment, where Chebyshev polynomials are exact.
    start, end = (motion.expand(every, np.full(motion.segments, x), short) for x in (-1.0, 1.0))
    count = start[0].r.shape[0]

    goals, is_free = entries(scenario, "goal"), option(scenario, "free_final_velocity", False)
    # Beside sets of poses the lists at the goal may be empty.
    given, count = {k: x for k, x in scenario.items() if x or not goals or "goal" not in k}, start[0].r.shape[0]
    q_start, v_start, q_goal, v_goal = (joint_values(given, f"{x}_{y}", count) for y in ("start", "goal") for x in "qv")
    default = "velocity" if option(scenario, "passive", []) else "acceleration"
    is_smooth = option(scenario, "continuity", default) == "acceleration"
    wanted = [
        (True, "the start position", start[0][:, 0], ball(q_start), STATE),
        (True, "the start velocity", start[1][:, 0], ball(v_start), STATE),
        (not goals, "the goal position", end[0][:, -1], ball(q_goal), STATE),
        (not is_free, "the goal velocity", end[1][:, -1], ball(v_goal), STATE),
    ]
    at_ends = [("start", start[2][:, 0], not any(v_start)), ("goal", end[2][:, -1], not is_free and not any(v_goal))]
    for name, found, is_at_rest in at_ends:
        a = joint_values(scenario, f"a_{name}", count)
        is_asked = option(scenario, f"a_{name}") is not None or (is_smooth and is_at_rest)
        wanted.append((is_asked, f"the {name} acceleration", found, ball(a), ACCELERATION))
    for k, name in enumerate(["positions", "velocities", "accelerations"]):
        most = STATE if k < 2 else ACCELERATION
        wanted.append((k < 2 or is_smooth, f"continuity of {name}", end[k][:, :-1], start[k][:, 1:], most))
    for is_asked, name, found, values, most in wanted:
        off = Model(found.c[:1], found.r) - Model(values.c[:1], values.r)
        require(not is_asked or np.all(off.most() <= most), f"{name} is not proved")


def outcome(key, scenario, robot):
    """What becomes of a key: `proved`, `assumed`, `left out` or `no promise`."""
    has_obstacles = bool(option(scenario, "obstacles", []))
    is_apart = robot.has_links and option(scenario, "self_collision") != "off"
    is_asked = {"obstacles": has_obstacles, "self_collision": is_apart, "clearance_m": has_obstacles or is_apart}
    if (key == "passive" and scenario[key]) or (is_asked.get(key, False) and not robot.is_known):
        return "left out"
    if key in "robot root mount gravity mimic locked_joints losses payload robot_shape".split():
        return "assumed"
    is_asked["q_goal"] = not entries(scenario, "goal")
    is_asked["v_goal"] = not option(scenario, "free_final_velocity", False)
    is_asked["horizon_s"] = "free_horizon" not in scenario and not weighs_time(scenario)
    proofs = "q_start v_start a_start start_tolerance a_goal goal keep waypoints stand continuity".split()
    proofs += ["free_horizon", "enforced_limits"]
    return "proved" if is_asked.get(key, key in proofs) else "no promise"


def left_out(scenario, robot, listed):
    """Checks the list of outcomes, and returns the keys that it leaves out."""
    known = {*scenario, "continuity", "enforced_limits", "self_collision"}
    missing = sorted(key for key, found in listed.items() if found.startswith("left out: "))
    for key in sorted(known):
        own, found = outcome(key, scenario, robot), listed.get(key)
        require(key in missing or found == own != "left out", f"'{key}' is listed as '{found}', and is {own}")
    require(set(listed) <= known | set(missing), "a key is listed that the scenario does not have")
    return missing


def weighs_time(scenario):
    """True if the objective has a cost of time, so that the horizon is free."""
    objective = option(scenario, "objective", "least-effort")
    return objective != "least-effort" if isinstance(objective, str) else option(objective, "time", 0.0) > 0.0


def cover(intervals, segments, claims):
    """The segments, middles, half widths and claims of the intervals, and the directions of pairs of shapes there."""
    segment, before, found, directions = 0, -1.0, [], {}
    for own, begin, end, reserves, listed in intervals:
        if before == 1.0:
            segment, before = segment + 1, -1.0
        m, w = 0.5 * (begin + end), 0.5 * (end - begin)
        is_exact = m - w == begin and m + w == end and w > 0.0
        is_next = own == segment < segments and begin == before
        require(is_exact and is_next, "the intervals do not cover the horizon")
        require(len(reserves) == claims, "a reserve is missing")
        before = end
        found.append((segment, m, w, reserves))
        for i, j, n in listed:
            directions.setdefault((i, j), []).append((len(found) - 1, n))
    require(segment == segments - 1 and before == 1.0, "the intervals do not cover the horizon")
    return found, directions


def check(robot, scenario, run, certificate, meshes=lambda name: None):
    """Checks a certificate, given the texts of the robot, of the scenario (or of the summary, which has it), of the
    summary of the solve and of the certificate, and the bytes of meshes by their names in the URDF, `None` for those
    that cannot be read; returns a `Report`, or raises `Refused`."""
    try:
        with np.errstate(all="ignore"):
            return _check(robot, scenario, run, certificate, meshes)
    except (ArithmeticError, LookupError, MemoryError, RecursionError, TypeError, ValueError, SyntaxError) as error:
        raise Refused(f"unreadable: {error!r}") from error


def check_intervals(scenario, robot, motion, tube, limits, pairs, promises, intervals, directions):
    """Checks the claims on all intervals, for positions within the tube about the motion."""
    of, middles, halves, claims = (np.array(list(column)) for column in zip(*intervals))
    claims = dict(zip(promises, claims.reshape(len(intervals), len(promises)).T))

    def refuse(what, wrong):
        """Refuses the first of the intervals on which this is not proved."""
        for segment, m, w, _ in [intervals[k] for k in sorted(wrong)[:1]]:
            raise Refused(f"segment {segment} from {m - w} to {m + w}: {what} is not proved")

    always, rounding = np.full(len(intervals), True), 1e-15 * motion.horizon
    begin, end = (motion.time(of, x) for x in (middles - halves, middles + halves))
    quantities = motion.expand(of, middles, halves)
    quantities[0] = quantities[0].widened(tube)
    q, v, a = (cut(part) for part in quantities[:3])
    states, rows = States(robot, q, v), []
    if {"torque", "power", "stand"} & set(promises):
        torques, ground = robot.torques(q, v, a)
        quantities += [torques, torques * v] if "power" in promises else [torques]
        if "stand" in promises:
            rows += [("stand", row, always) for row in states.foot(scenario["stand"], *ground)]
    for promise, joint, bounds, from_s in limits:
        scale = max(abs(x) for x in bounds if math.isfinite(x)) or 1.0
        name, value = f"{promise} of joint '{robot.joints[joint].name}'", quantities[KINDS.index(promise)][joint]
        rows.append((promise, (name, value, bounds, scale), end + rounding > from_s))
    for i, condition in enumerate(option(scenario, "keep", [])):
        from_s, to_s = option(condition, "from_s", 0.0), option(condition, "to_s", math.inf)
        require(from_s < min(to_s, motion.horizon), f"keep[{i}] from {from_s} to {to_s} s is at no time of the motion")
        inside = (end + rounding > from_s) & (begin - rounding < to_s)
        rows += [("keep", row, inside) for row in states.kept(condition)]
    for promise, row, inside in rows:
        good = proved(row, claims[promise]) | ~inside
        refuse(row[0], np.flatnonzero(~good))
    if pairs:
        obstacles, placed = obstacles_of(scenario), robot.placed(states.places)
        for promise, own in pairs.items():
            if robot.has_balls:
                check_balls(promise, own, claims[promise], robot, obstacles, placed, refuse)
            else:
                check_shapes(promise, own, claims[promise], robot, obstacles, placed, directions, refuse)


def _check(robot_text, scenario_text, run_text, certificate_text, meshes):
    run, certificate = read(run_text, "run"), read(certificate_text, "certificate")
    texts = robot_text, scenario_text, run_text
    robot_hash, scenario_hash, run_hash = (hashlib.sha256(text.encode()).hexdigest() for text in texts)
    require(certificate["robot_sha256"] == robot_hash, "the certificate is of another robot")
    require(certificate["run_sha256"] == run_hash, "the certificate is of another motion")
    if scenario_text == run_text:
        scenario = option(option(run, "provenance"), "scenario")
        accept(scenario, "scenario")
    else:
        known = scenario_hash in certificate["scenario_sha256"]
        require(known, "the certificate is of another scenario; `aghf scenarios FILE` writes a scenario in full")
        scenario = read(scenario_text, "scenario")
    motion, names = Motion(run["curve"]), run["curve"]["joints"]
    free, fixed = option(scenario, "free_horizon", {}), scenario["horizon_s"]
    least, most = (0.0, math.inf) if weighs_time(scenario) else (fixed, fixed)
    start = option(scenario, "start_tolerance")
    is_back = start is None or motion.horizon >= option(start, "back_s", 0.25)
    require(is_back, "the motion ends before start_tolerance.back_s")
    is_asked = option(free, "shortest_s", least) <= motion.horizon <= option(free, "longest_s", most)
    require(is_asked, "the horizon is not that of the scenario")
    pieces = [[read_piece(*piece) for piece in mesh] for mesh in certificate["pieces"]]
    robot = Robot(robot_text, scenario, names, pieces)
    unread = check_meshes(robot, pieces, certificate["meshes"], meshes)
    missing = left_out(scenario, robot, certificate["keys"])
    require(certificate["complete"] is (not missing), "'complete' is wrong")
    limits = limits_of(scenario, robot)
    check_ends(scenario, motion)
    pairs = pairs_of(scenario, robot)
    promises = [kind for kind in KINDS if any(limit[0] == kind for limit in limits)]
    promises += [key for key in ("keep", "stand") if option(scenario, key)] + list(pairs)
    require(certificate["promises"] == promises, f"the promises are {promises}")
    check_places(scenario, certificate, robot, motion)
    intervals, directions = cover(certificate["intervals"], motion.segments, len(promises))
    tube = certificate["tracking_error"]
    check_intervals(scenario, robot, motion, tube, limits, pairs, promises, intervals, directions)
    proved = ", ".join(["horizon", "ends", *(k for k in ("goal", "waypoints") if entries(scenario, k)), *promises])
    within = f" for positions within {tube:g} of the motion" if tube else ""
    missing += [f"that the pieces of '{name}' contain this mesh" for name in unread]
    tail = f"; not certified: {', '.join(missing)}" if missing else ""
    outcome = "certified in part" if missing else "certified"
    return Report(f"{outcome} at all times{within}, by {len(intervals)} intervals: {proved}{tail}", not missing)


def main(files):
    try:
        usage = "usage: python -m aghf.check_certificate ROBOT.urdf SCENARIO SUMMARY CERTIFICATE [FOLDER ...]"
        require(len(files) >= 4, usage)
        texts = (Path(file).read_bytes().decode() for file in files[:4])
        report = check(*texts, lambda name: find_mesh(name, files[0], files[4:]))
    except (OSError, UnicodeError, Refused) as fault:
        print(f"refused: {fault}", file=sys.stderr)
        return 1
    print(report.text)
    return 0 if report.is_complete else 4


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
