"""The checker of certificates on a small robot: what the page of the format has is accepted, all else is refused."""

import copy
import hashlib
import json

import pytest

from aghf.check_certificate import Refused, check, main

# Two joints that stand still, and all that is promised of them.
LINK = """<link name="{0}"><inertial><origin xyz="0.2 0 0"/><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><{1}/></geometry></collision></link>"""
JOINT = """<joint name="{0}" type="revolute"><origin xyz="0 0 1"/><parent link="{1}"/><child link="{2}"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="2" effort="60"/></joint>"""
FIXED = """<link name="{0}"/><joint name="fixed" type="fixed"><parent link="{1}"/><child link="{0}"/></joint>"""
URDF = "\n".join([
    '<?xml version="1.0"?><robot name="two">',
    LINK.format("base", 'sphere radius="0.1"'),
    LINK.format("arm", 'box size="0.1 0.1 0.1"'),
    LINK.format("tip", 'cylinder radius="0.1" length="0.2"'),
    JOINT.format("j1", "base", "arm"),
    JOINT.format("j2", "arm", "tip"),
    "</robot>",
])
SCENARIO = {
    "robot": "two.urdf",
    "horizon_s": 2.0,
    "q_start": [0.0, 0.0],
    "v_start": [0.0, 0.0],
    "goal": [
        {
            "frame": "tip",
            "position_m": [0, 0, 2],
            "tolerance_m": 1,
            "orientation_xyzw": [0, 0, 0, 1],
            "tolerance_rad": 0.2,
        }
    ],
    "keep": [{"speed": {"frame": "tip", "most_m_s": 1.0}, "from_s": 0.5}],
    "waypoints": [{"q": [0.0, 0.0], "stop": True, "time_s": 1.0}],
    "stand": {"frame": "base", "half_length_m": 0.5, "half_width_m": 0.5, "friction": 0.5},
    "obstacles": [{"shape": {"sphere": {"radius_m": 0.5}}, "pose": {"position_m": [3, 0, 0]}, "clearance_m": 0.1}],
    "clearance_m": {"obstacles": 0.1, "pairs": [{"links": ["base", "tip"], "clearance_m": 1.78}]},
    "enforced_limits": {"position": 0.9, "torque": {"share": 0.5, "joints": ["j1"]}, "jerk": [1.0, None]},
}
PROMISES = ["position", "velocity", "jerk", "torque", "keep", "stand", "obstacles", "self_collision"]
ZERO = [0.0, 0.0, 0.0]
RUN = {
    "verdict": {"any": None},
    "curve": {"horizon_s": 2.0, "segments": 1, "degree": 2, "joints": ["j1", "j2"], "coefficients": [[ZERO] * 4]},
}
OUTCOMES = dict.fromkeys([*SCENARIO, "continuity", "self_collision"], "proved")
CERTIFICATE = {
    "format": "aghf-certificate-5",
    "scenario": "two",
    "meshes": {},
    "pieces": [],
    "complete": True,
    "keys": OUTCOMES | {"robot": "assumed"},
    "tracking_error": 0.0,
    "goal": 0.01,
    "waypoints": [[0, 0.0, 0.0]],
    "promises": PROMISES,
    "intervals": [[0, -1.0, 1.0, [0.01] * len(PROMISES), [[1, 2, [0.0, 0.0, 1.0]]]]],
}


def texts_of(robot=URDF, scenario=SCENARIO, run=RUN, certificate=CERTIFICATE):
    """The texts, with the hashes of the first three in the certificate."""
    scenario, run = (x if isinstance(x, str) else json.dumps(x) for x in (scenario, run))
    robot_hash, scenario_hash, run_hash = (hashlib.sha256(x.encode()).hexdigest() for x in (robot, scenario, run))
    hashes = {"robot_sha256": robot_hash, "scenario_sha256": [scenario_hash], "run_sha256": run_hash}
    certificate = certificate if isinstance(certificate, str) else json.dumps(certificate | hashes)
    return robot, scenario, run, certificate


def changed(value, path, new):
    """A copy with another value at a path of keys, or without it if the value is `...`."""
    value = copy.deepcopy(value)
    inner = value
    for key in path[:-1]:
        inner = inner[key]
    if new is ...:
        del inner[path[-1]]
    else:
        inner[path[-1]] = new
    return value


def test_exit_codes_tell_all_from_a_part(tmp_path, capsys):
    part = CERTIFICATE | {"complete": False, "keys": CERTIFICATE["keys"] | {"rows of mine": "left out: in code"}}
    nothing = CERTIFICATE | {"complete": False}
    for certificate, code in ((CERTIFICATE, 0), (part, 4), (nothing, 1)):
        files = [tmp_path / name for name in ("two.urdf", "scenario.json", "summary.json", "certificate.json")]
        for file, text in zip(files, texts_of(certificate=certificate)):
            file.write_text(text)
        assert main([str(file) for file in files]) == code
        written = capsys.readouterr()
        assert (code == 4) == ("in part" in written.out and "not certified: rows of mine" in written.out)
    files[0].write_bytes(b"\xff")
    assert main([str(file) for file in files]) == 1


def objects(value, path=()):
    """The paths of all objects."""
    if isinstance(value, dict):
        yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in inner:
        yield from objects(entry, (*path, key))


@pytest.mark.parametrize("name", ["scenario", "run", "certificate"])
def test_unknown_and_repeated_keys_are_refused_at_every_place(name):
    whole = {"scenario": SCENARIO, "run": RUN, "certificate": CERTIFICATE}[name]
    # A summary has others outside of its curve.
    free = [path for path in objects(whole) if name == "run" and path != ("curve",)]
    for path in objects(whole):
        inner = whole
        for key in path:
            inner = inner[key]
        first = next(iter(inner), "x")
        for key in ("", "x", f"{first}?", f"{first}*", first.upper()):
            texts = texts_of(**{name: changed(whole, (*path, key), "x")})
            if path in free:
                check(*texts)
                continue
            with pytest.raises(Refused, match="not in the subset|are missing|are not those|is listed|this is no|named"):
                pytest.fail(f"{name} {path} {key}: {check(*texts)}")
        marked = json.dumps(changed(whole, (*path, "@@"), 0)).replace('"@@": 0', '"@": 0, "@": 0')
        with pytest.raises(Refused, match="a key is repeated"):
            pytest.fail(f"{name} {path}: {check(*texts_of(**{name: marked}))}")


HALF = {"poses": {"frame": "tip", "position_m": [0, 0, 0]}}
REFUSED = [
    ("scenario", ("horizon_s",), [0, -2, 3.0, True, "2", None, 1e7]),
    ("scenario", ("q_start",), [[], [0.0], [0.0] * 3, [0.0, 2e-9], [0.0, True]]),
    ("scenario", ("goal",), [..., SCENARIO["goal"] + [{"frame": "x", "position_m": [0, 0, 0]}]]),
    ("scenario", ("goal", 0, "tolerance_m"), [0.0, -0.1]),
    ("scenario", ("goal", 0, "position_m"), [..., [0, 0, 3.1]]),
    ("scenario", ("goal", 0, "tolerance_rad"), [0.0, 3.2]),
    ("scenario", ("goal", 0, "orientation_xyzw"), [[0, 0, 0, 2], [0, 0, 0, 1.01], [0, 1e200, 0, 1e200], [0, 0, 1]]),
    ("scenario", ("goal", 0, "axis"), [{"of_frame": [0, 0, 1], "direction": [0, 0, 1]}]),
    ("scenario", ("goal", 0, "box"), [{"size_m": [1, 1, 1], "pose": {"position_m": [0, 0, 2]}}]),
    ("scenario", ("keep", 0, "from_s"), [2.0, -1.0]),
    ("scenario", ("keep", 0, "to_s"), [0.5, 0.0]),
    ("scenario", ("keep", 0, "poses"), [HALF["poses"]]),
    ("scenario", ("waypoints", 0, "poses"), [HALF["poses"]]),
    ("scenario", ("waypoints", 0, "time_s"), [1.0 + 1e-11, 0.0]),
    ("scenario", ("waypoints", 0, "q"), [..., [0.0], [0.0, 2e-6]]),
    ("scenario", ("stand", "frame"), ["tip", "x", ""]),
    ("scenario", ("stand", "friction"), [0.0, -0.1]),
    ("scenario", ("obstacles", 0, "shape"), [{"sphere": {"radius_m": -3.0}}, {"sphere": {}}, {"ball": {}}]),
    ("scenario", ("obstacles", 0, "pose", "position_m"), [[0, 0, -1e15], [0.5, 0, 1], [0, 0]]),
    ("scenario", ("obstacles", 0, "clearance_m"), [-0.5, 3.0]),
    ("scenario", ("clearance_m",), [-0.1, {"pairs": [SCENARIO["clearance_m"]["pairs"][0]] * 2}]),
    ("scenario", ("clearance_m", "pairs", 0, "links"), [["base", "base"], ["base", "x"], ["base"]]),
    ("scenario", ("clearance_m", "pairs", 0, "clearance_m"), [1.9]),
    ("scenario", ("self_collision",), ["off", "on", {"ignored_pairs": [["base", "tip"], ["tip", "base"]]}]),
    ("scenario", ("enforced_limits", "position"), [5.0, 0.0, "all"]),
    ("scenario", ("enforced_limits", "torque"), [{"joints": ["x"]}, {"share": 1e-3}]),
    ("scenario", ("enforced_limits", "jerk"), [[1.0], [1.0, -1.0], False]),
    ("scenario", ("passive",), [["x"], ["j1", "x"]]),
    ("scenario", ("root",), ["x", ""]),
    ("scenario", ("locked_joints",), [{"j1": 0.0}, {"x": 0.0}]),
    ("scenario", ("payload",), [{"link": "base", "mass_kg": 1.0}, {"link": "tip", "mass_kg": -1.0}]),
    ("scenario", ("robot_shape",), [{"swept_links": {"radius_m": 0.1, "spacing_m": 1e-300}}, "joint_frames", "x"]),
    ("scenario", ("continuity",), ["jerk"]),
    ("scenario", ("objective",), ["least-effort-", {"time": -1.0}]),
    ("run", ("curve", "segments"), [2, 1.0, 0]),
    ("run", ("curve", "degree"), [1, 3, 2.0]),
    ("run", ("curve", "joints"), [["j1"], ["j1", "j1"], ["j1", "x"], ["j2", "j1"]]),
    ("run", ("curve", "coefficients", 0, 0), [[1e-8, 0.0, 0.0], [0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]),
    ("run", ("curve", "coefficients", 0, 3), [[0.0, 0.0, 2e-9]]),
    ("run", ("curve", "coefficients"), [[], [[]], [[ZERO] * 2], [[ZERO] * 4] * 2]),
    ("certificate", ("goal",), [..., 0.2, 1e308]),
    ("certificate", ("waypoints",), [[], [[0, 0.1, 0.0]], [[1, 0.0, 0.0]], [[0, 0.0, 2e-6]]]),
    ("certificate", ("promises",), [PROMISES[1:], PROMISES[::-1]]),
    ("certificate", ("tracking_error",), [-1e-3, 0.5, 1e308]),
    ("certificate", ("intervals", 0, 2), [0.0, 1.5, 1.0 - 2.0**-53]),
    ("certificate", ("intervals", 0, 3), [[1.7976931348623157e308] * 8, [1.1] * 8, [1.0] * 8, [0.01] * 7]),
    ("certificate", ("intervals", 0, 4), [[[1, 2, n]] for n in ([0, 0, -1], [1, 0, 0], ZERO, [0, 0, 1e7], [1])]),
    ("certificate", ("keys", "robot"), ["proved", "no promise", ..., ""]),
    ("certificate", ("keys", "goal"), ["left out", "no promise", "left out: yes"]),
    ("certificate", ("meshes",), [{"a.stl": "0" * 64}]),
]


@pytest.mark.parametrize("name, path, values", REFUSED)
def test_what_the_page_does_not_have_is_refused(name, path, values):
    whole = {"scenario": SCENARIO, "run": RUN, "certificate": CERTIFICATE}
    if name == "scenario" and path[0] not in OUTCOMES:
        # With the outcome that it would have.
        own = {"objective": "no promise", "passive": "left out: a reason"}.get(path[0], "assumed")
        keys = CERTIFICATE["keys"] | {path[0]: own}
        whole["certificate"] = CERTIFICATE | {"keys": keys, "complete": path[0] != "passive"}
    for value in values:
        with pytest.raises(Refused, match="^(?!unreadable)"):
            pytest.fail(f"{value}: {check(*texts_of(**whole | {name: changed(whole[name], path, value)}))}")


# With torques of 2 g 0.2 m of 30 Nm, at rest, and with the weight at 0.2 m of 0.5 m and no friction of 0.5.
@pytest.mark.parametrize("promise, most", [("torque", 1.0 - 0.4 * 9.81 / 30.0), ("keep", 0.5), ("stand", 0.25)])
def test_reserves_are_in_their_units(promise, most):
    path = ("intervals", 0, 3, PROMISES.index(promise))
    assert check(*texts_of(certificate=changed(CERTIFICATE, path, most - 1e-6))).is_complete
    with pytest.raises(Refused, match="is not proved"):
        check(*texts_of(certificate=changed(CERTIFICATE, path, most + 1e-6)))


def test_waypoints_are_in_their_order():
    scenario = changed(SCENARIO, ("waypoints",), [{"q": [0.0, 0.0]}] * 2)
    for places in ([-0.5, 0.5], [0.5, -0.5]):
        texts = texts_of(scenario=scenario, certificate=CERTIFICATE | {"waypoints": [[0, x, 0.0] for x in places]})
        if places[0] < places[1]:
            assert check(*texts).is_complete
        else:
            with pytest.raises(Refused, match="before another one"):
                check(*texts)


def test_rest_and_windows_of_a_motion():
    # The first joint at 0.1 (1 - x^2)^2 rad, x = t / s - 1, with the speed 0.4 (x - x^3) m/s of the tip.
    rows = [[0.0375, 0.0, -0.05, 0.0, 0.0125], [0.0] * 5, [0.0, -0.1, 0.0, 0.1, 0.0], [0.0] * 5]
    run = {"curve": RUN["curve"] | {"degree": 4, "coefficients": [rows]}}
    keep = [{"speed": {"frame": "tip", "most_m_s": 0.12}, "from_s": 1.2, "to_s": 1.24}]
    scenario = SCENARIO | {"continuity": "velocity", "enforced_limits": {}, "waypoints": [], "keep": keep}
    scenario["stand"] = SCENARIO["stand"] | {"friction": 5.0}
    promises = ["position", "velocity", "torque", *PROMISES[4:]]
    intervals = [[0, *ends, [0.0] * 7, []] for ends in ((-1.0, 0.125), (0.125, 0.25), (0.25, 0.375), (0.375, 1.0))]
    certificate = CERTIFICATE | {"promises": promises, "intervals": intervals, "waypoints": []}
    assert check(*texts_of(URDF, scenario, run, certificate)).is_complete
    free = {"continuity": "acceleration", "free_final_velocity": True}
    free_keys = {"keys": CERTIFICATE["keys"] | {"free_final_velocity": "no promise"}}
    for change, keys, why in (
        ({"continuity": "acceleration"}, {}, "the start acceleration"),
        (free, free_keys, "the start acceleration"),
        ({"keep": [keep[0] | {"to_s": 1.5}]}, {}, "speed"),
    ):
        with pytest.raises(Refused, match=why):
            check(*texts_of(URDF, scenario | change, run, certificate | keys))


def test_hashes_are_compared():
    texts = texts_of()
    for i, why in enumerate(["another robot", "another scenario", "another motion"]):
        other = [f"{text} " if k == i else text for k, text in enumerate(texts)]
        with pytest.raises(Refused, match=why):
            check(*other)


TWICE = FIXED.format("a", "tip") + FIXED.format("b", "tip")
ROBOTS = [
    ('<robot name="two">', ['<robot name="two" x="1">', '<bot name="two">', '<?p x?><robot name="two">']),
    ('<?xml version="1.0"?>', ["<!DOCTYPE r>", '<!DOCTYPE r [<!ENTITY a "1">]>', "\ufeff", "x"]),
    ('<link name="base">', ['<link name="">', '<link name="arm">', "<link>", '<link name="base" x:y="1" xmlns:x="u">']),
    ('<mass value="1"/>', ['<mass value="-1"/>', '<mass value="1" v="2"/>', '<mass value="1"/><mass value="1"/>', ""]),
    ('radius="0.1"', ['radius="-0.1"', 'radius="0"', 'radius="1e7"', 'radius="0.1 9"', 'radius="inf"', 'radius="0_1"']),
    ('size="0.1 0.1 0.1"', ['size="0.1 0.1"', 'size="0.1 0.1 0.1 1"', 'size="\u0661 1 1"', 'size="1\u00a01 1 1"']),
    ('<sphere radius="0.1"/>', ['<box size="2 2 2"/><sphere radius="0.1"/>', '<cone radius="0.1"/>']),
    ('<child link="tip"/>', ['<child link="base"/>', '<child link="arm"/>', '<child link="x"/>', "<child/>"]),
    ('<joint name="j2"', ['<joint name="j1"', '<joint name="j3"', '<joint name=""']),
    ("</robot>", [f"{TWICE}</robot>", f"{FIXED.format('a', 'a')}</robot>"]),
    ('type="revolute"', ['type="floating"', 'type="fixed"', ""]),
    ('<axis xyz="0 1 0"/>', ['<axis xyz="0 1"/>', "<axis/>", '<axis xyz="0 1 0"/><mimic joint="j1"/>']),
    ('<limit lower="-1"', ['<limit lower="2"', '<x:limit xmlns:x="u"/><limit lower="-1"', '<limit soft="1"']),
    ('effort="60"', ['effort="-60"', 'effort="1e6 60"', 'effort="1e-6"', 'effort="1e999"', 'effort="nan"']),
]


@pytest.mark.parametrize("old, new", ROBOTS)
def test_other_robots_are_refused(old, new):
    assert old in URDF
    for text in new:
        with pytest.raises(Refused, match="^(?!unreadable: (?!ParseError))"):
            pytest.fail(f"{text}: {check(*texts_of(robot=URDF.replace(old, text, 1)))}")


def test_json_is_strict():
    good = json.dumps(RUN)
    assert check(*texts_of(run=good.replace('"any": null', '"any": ' + "[" * 124 + "]" * 124))).is_complete
    assert check(*texts_of(run=good.replace("null", '"\\ud83d\\ude00 [[ \\" {{"'))).is_complete
    numbers = ["NaN", "Infinity", "-Infinity", "1e999", "1" * 400, "1" * 5000, "01", "1.", "+1"]
    others = ["'x'", '"\\ud800"', '"\t"', '{"a": 1, "a": 1}', "1, ", "\ufeff1"]
    for value in [*numbers, *others, "[" * 126 + "]" * 126, "[" * 200_000]:
        with pytest.raises(Refused, match="^run: "):
            pytest.fail(f"{value[:20]}: {check(*texts_of(run=good.replace('null', value)))}")
    for index in ("-0", "0.0", "0e0", "1000001"):
        text = texts_of()[3].replace("[[0, -1.0", f"[[{index}, -1.0")
        with pytest.raises(Refused, match="index|cover"):
            check(*texts_of()[:3], text)
