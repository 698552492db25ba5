"""Robots: what they say of themselves, and what is refused."""

import copy
import pickle

import numpy as np
import pytest

import aghf

URDF = """<robot name="slide"><link name="base"/><link name="cart"><inertial><mass value="2"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="2" velocity="3" effort="4"/></joint></robot>"""

#: The same with a mass on both sides, losses and a mesh.
RICH = URDF.replace('<link name="base"/>', """<link name="base"><inertial><mass value="5"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>""").replace("</inertial></link>\n<joint",
"""</inertial><collision><geometry><mesh filename="package://parts/cart.stl"/></geometry></collision></link>
<joint""").replace("<limit", '<dynamics damping="0.5" friction="1.5"/><limit')


def test_a_model_tells_what_its_urdf_says(tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(URDF)
    for model in [aghf.Model.from_urdf(URDF), aghf.Model.from_urdf(path), aghf.Model.from_urdf(str(path))]:
        assert (model.name, model.dof, model.mass) == ("slide", 1, 2.0)
        assert (model.joint_names, model.joint_kinds) == (["rail"], ["prismatic"])
        limits = [model.lower, model.upper, model.velocity_limits, model.effort_limits]
        assert [x.tolist() for x in limits] == [[-1.0], [2.0], [3.0], [4.0]]
        assert model.parents.tolist() == [-1]
        assert model.frame_names == ["base", "cart"]
    assert aghf.rnea(model, [0.5], [0.0], [3.0]) == pytest.approx([6.0])
    again = aghf.Model.from_urdf(model.to_urdf())
    assert again.joint_names == model.joint_names
    assert repr(model) == "Model('slide', 1 joints)"


def test_models_are_pickled_and_copied(tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(URDF)
    for model in [aghf.Model.from_urdf(URDF), aghf.Model.from_urdf(path), aghf.Model.builtin("kinova_gen3")]:
        q = np.full(model.dof, 0.5)
        for again in [pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)]:
            assert again.name == model.name
            assert np.array_equal(aghf.crba(again, q), aghf.crba(model, q))


def test_another_root():
    assert aghf.Model.from_urdf(RICH).mass == 2.0
    turned = aghf.Model.from_urdf(RICH, root="cart")
    assert (turned.mass, turned.joint_names, turned.frame_names[0]) == (5.0, ["rail"], "cart")


def test_losses_are_those_of_the_urdf_or_are_given():
    # The share of the friction at 3 m/s.
    share = 3.0 / np.hypot(3.0, 0.02)
    for losses, expected in [
        (False, 2.0),
        (True, 2.0 + 0.5 * 3.0 + 1.5 * share),
        ({"damping": 1.0}, 2.0 + 1.0 * 3.0 + 1.5 * share),
        ({"friction": {"rail": np.float64(0.25)}, "armature": 4}, 2.0 + 4.0 + 0.5 * 3.0 + 0.25 * share),
        ({"friction_velocity": 3.0}, 2.0 + 0.5 * 3.0 + 1.5 / np.sqrt(2.0)),
    ]:
        model = aghf.Model.from_urdf(RICH, losses=losses)
        assert aghf.rnea(model, [0.5], [3.0], [1.0]) == pytest.approx([expected], rel=1e-12), losses


def test_packages_have_folders(tmp_path, monkeypatch):
    assert "package://parts/cart.stl" in aghf.Model.from_urdf(RICH).to_urdf()
    monkeypatch.chdir(tmp_path)
    for folder in [tmp_path / "own", "own"]:
        model = aghf.Model.from_urdf(RICH, packages={"parts": folder})
        assert f'"{tmp_path / "own" / "cart.stl"}"' in model.to_urdf()


def test_options_of_a_urdf_are_pickled(tmp_path, monkeypatch):
    path = tmp_path / "slide.urdf"
    path.write_text(RICH)
    monkeypatch.chdir(tmp_path)
    sources = [RICH, "slide.urdf"]
    lossy = [aghf.Model.from_urdf(source, root="cart", losses={"damping": 2.0}) for source in sources]
    packed = [aghf.Model.from_urdf(source, packages={"parts": "own"}) for source in sources]
    pickled = pickle.dumps([lossy, packed])
    monkeypatch.chdir("/")
    for again in pickle.loads(pickled)[0]:
        assert aghf.rnea(again, [0.5], [3.0], [1.0]) == aghf.rnea(lossy[0], [0.5], [3.0], [1.0])
    for again in pickle.loads(pickled)[1]:
        assert again.to_urdf() == packed[0].to_urdf()


@pytest.mark.parametrize(
    ("options", "element", "words"),
    [
        ({"root": "hand"}, "root 'hand'", "no such link"),
        ({"losses": {"damping": {"elbow": 1.0}}}, "losses.damping.elbow", "no such joint"),
        ({"losses": {"damping": -1.0}}, "joint 'rail'", "damping is -1"),
        ({"losses": {"weight": 1.0}}, "losses", "friction_velocity"),
        ({"losses": "all"}, "losses", "true, false or an object"),
    ],
)
def test_bad_options_of_a_urdf(options, element, words, tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(RICH)
    for source, file in [(path, str(path)), (RICH, "URDF")]:
        with pytest.raises(aghf.InputError) as raised:
            aghf.Model.from_urdf(source, **options)
        error = raised.value
        assert (error.file, error.element) == (file, element) and words in error.condition, error
    with pytest.raises(TypeError):
        aghf.Model.from_urdf(RICH, packages={"parts": 3})
    with pytest.raises(TypeError):
        aghf.Model.from_urdf(RICH, losses={"damping": object()})


def test_attributes_are_those_of_the_documentation():
    model = aghf.Model.builtin("pendulum_2")
    for name in ["dof", "mass", "joint_names", "parents", "lower", "effort_limits", "gravity", "notes"]:
        assert name in dir(model) and getattr(model, name) is not None
    with pytest.raises(AttributeError):
        model.joints


def test_all_robots_that_are_built_in():
    for name in aghf.builtin_robots():
        model = aghf.Model.builtin(name)
        assert np.isfinite(aghf.crba(model, np.zeros(model.dof))).all()


def test_bad_robots_are_errors_with_file_element_and_condition(tmp_path):
    path = tmp_path / "bad.urdf"
    path.write_text(URDF.replace('value="2"', 'value="two"'))
    with pytest.raises(aghf.InputError) as raised:
        aghf.Model.from_urdf(path)
    error = raised.value
    assert error.file == str(path) and "cart" in error.element and "two" in error.condition
    assert str(error) == f"{error.file}: {error.element}: {error.condition}"
    assert isinstance(error, ValueError)
    with pytest.raises(OSError):
        aghf.Model.from_urdf(tmp_path / "nowhere.urdf")
    with pytest.raises(aghf.InputError, match="none"):
        aghf.Model.builtin("none")
    with pytest.raises(aghf.InputError, match="mimic"):
        aghf.Model.from_urdf(URDF, mimic="maybe")
