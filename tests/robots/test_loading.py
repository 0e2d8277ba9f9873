"""Robots from files: what is made of a URDF, and what a file that cannot be used is told."""

import warnings

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import InputError, RobotError, SkillfoldError
from skillfold.robots import loading

INERTIA = '<inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/>'


def link(name, inside=""):
    return f'<link name="{name}">{inside}</link>'


def joint(name, parent, child, kind="revolute", inside="", z=0.4, axis="0 1 0"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 {z}"/>'
        f'<axis xyz="{axis}"/><limit lower="-1.5" upper="1.5" effort="40" velocity="2"/>{inside}</joint>'
    )


def collision(shape='<cylinder radius="0.05" length="0.3"/>'):
    return f'<collision><origin xyz="0 0 0.2"/><geometry>{shape}</geometry></collision>'


def inertial(mass=1.0):
    return f'<inertial><origin xyz="0 0 0.2"/><mass value="{mass}"/>{INERTIA}</inertial>'


def arm(*more, upper=None, lower=None):
    parts = [
        link("base_link"),
        link("upper", inertial() + collision() if upper is None else upper),
        link("lower", inertial() + collision() if lower is None else lower),
        link("tool0"),
        joint("shoulder", "base_link", "upper", z=0),
        joint("elbow", "upper", "lower", "continuous"),
        joint("flange", "lower", "tool0", "fixed"),
        *more,
    ]
    return f'<robot name="two_links">{"".join(parts)}</robot>'


def load(tmp_path, text, name="robot.urdf"):
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    return sf.Robot.load(file)


def cube(file):
    corners = [f"v {x} {y} {z}" for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (0, 0.3)]
    faces = ["f 1 2 3", "f 2 4 3", "f 5 7 6", "f 6 7 8", "f 1 5 2", "f 2 5 6"]
    faces += ["f 3 4 7", "f 4 8 7", "f 1 3 5", "f 3 7 5", "f 2 6 4", "f 4 6 8"]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join([*corners, *faces]))


def test_a_urdf_keeps_links_limits_and_tool(tmp_path):
    robot = load(tmp_path, arm())
    assert robot.name == "two_links"
    assert robot.names == ("shoulder", "elbow")
    assert set(robot.frames) == {"base_link", "upper", "lower", "tool0"}
    assert robot.tool == "tool0"
    assert robot.space.kinds == ("angle", "continuous")
    np.testing.assert_array_equal(robot.torque_limits, [40, 40])
    np.testing.assert_array_equal(robot.velocity_limits, [2, 2])
    assert np.isinf(robot.acceleration_limits).all()
    q = np.array([0.3, 0.5])
    wanted = 0.4 * np.array([np.sin(0.3) + np.sin(0.8), 0, np.cos(0.3) + np.cos(0.8)])
    np.testing.assert_allclose(robot.forward(q)[:3], wanted, atol=1e-12)
    assert robot.obstacles([sf.Sphere(center=(0, 0, 1.0), radius=0.1)]).clearance([0, 0]) == pytest.approx(0.15)


def test_visual_meshes_are_not_looked_for(tmp_path):
    visual = '<visual><geometry><mesh filename="package://gone/arm.dae"/></geometry></visual>'
    robot = load(tmp_path, arm(upper=visual + inertial() + collision()))
    assert robot.notes == ()


def test_missing_inertias_are_made_up_and_named(tmp_path):
    robot = load(tmp_path, arm(upper=collision(), lower=""))
    assert any("upper" in note and "water" in note for note in robot.notes)
    assert any("lower" in note and "1 g" in note for note in robot.notes)
    assert np.isfinite(robot.center_of_mass([0.1, 0.2])).all()


def test_an_inertia_without_mass_is_none(tmp_path):
    robot = load(tmp_path, arm(upper=inertial(0) + collision()))
    assert any("upper" in note for note in robot.notes)


def test_mimic_joints_follow(tmp_path):
    mimic = '<mimic joint="elbow" multiplier="-2" offset="0.1"/>'
    more = link("finger", inertial()), joint("follow", "lower", "finger", inside=mimic)
    robot = load(tmp_path, arm(*more))
    assert robot.couplings == {"follow": "elbow"}
    np.testing.assert_allclose(robot.couple([0.2, 0.3, 9.0]), [0.2, 0.3, -0.5])
    pose = robot.forward([0.0, 0.3, 9.0], "finger")
    turned = 2 * np.arctan2(pose[5], pose[3])
    assert turned == pytest.approx(0.3 - 0.5)


def test_followers_of_followers_follow_the_first(tmp_path):
    first = '<mimic joint="elbow" multiplier="2" offset="0.1"/>'
    second = '<mimic joint="a" multiplier="3" offset="0.2"/>'
    more = (
        link("x", inertial()),
        link("y", inertial()),
        joint("a", "lower", "x", inside=first),
        joint("b", "lower", "y", inside=second),
    )
    robot = load(tmp_path, arm(*more))
    q = dict(zip(robot.names, robot.couple([0.0, 0.1, 0, 0]), strict=True))
    assert q["a"] == pytest.approx(0.3)
    assert q["b"] == pytest.approx(1.1)


HELD = """<mujoco><compiler angle="radian"/><worldbody><body><joint name="a" axis="0 0 1"/><geom size="0.1"/>
<body pos="1 0 0"><joint name="b" axis="0 0 1" ref="0.2"/><geom size="0.1"/>
<body name="tool" pos="1 0 0"><joint name="c" axis="0 0 1"/><geom size="0.1"/></body></body></body></worldbody>
<equality><joint joint1="b" polycoef="0.3 0 0 0 0"/><joint joint1="c" joint2="b" polycoef="0.1 2 0 0 0"/></equality>
</mujoco>"""


def test_a_joint_held_at_a_constant_stays_there_and_so_do_its_followers(tmp_path):
    """MuJoCo counts from where the joint stands in qpos0, which is its ref."""
    file = tmp_path / "held.xml"
    file.write_text(HELD)
    robot, model = sf.Robot.load(file), mujoco.MjModel.from_xml_string(HELD)
    np.testing.assert_allclose(robot.couple([0.7, 9.0, 9.0]), [0.7, 0.5, 0.1 + 2 * 0.3])
    data = mujoco.MjData(model)
    data.qpos[:] = robot.couple([0.7, 9.0, 9.0])
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY], 0, atol=1e-12)
    np.testing.assert_array_equal(robot.forward([0.7, 9.0, 9.0]), robot.forward([0.7, 0.0, 0.0]))
    assert not robot.jacobian([0.7, 0.0, 0.0])[:, 1:].any()
    assert robot.obstacles().n_pairs == 0  # nothing moves against anything else


@pytest.mark.parametrize(
    ("tie", "told"),
    [
        ('<connect body1="a" body2="b" anchor="0 .3 0"/>', "connect of a and b"),
        ('<weld body1="a" active="false"/><weld body1="b"/>', "itself, whatever the model ties together: weld of b."),
        ('<tendon tendon1="t"/>', "tendon of t"),
    ],
)
def test_ties_that_are_not_kept_are_told(tmp_path, tie, told):
    bodies = "".join(f"<body name='{name}'><joint name='{name}'/><geom size='.1'/></body>" for name in "ab")
    tendon = "<tendon><fixed name='t'><joint joint='a' coef='1'/></fixed></tendon>"
    text = f"<mujoco><worldbody>{bodies}</worldbody>{tendon}<equality>{tie}</equality></mujoco>"
    (note,) = load(tmp_path, text, "tied.xml").notes
    assert told in note


def test_joints_that_follow_in_a_circle_are_an_error(tmp_path):
    more = (
        link("x", inertial()),
        link("y", inertial()),
        joint("a", "lower", "x", inside='<mimic joint="b"/>'),
        joint("b", "lower", "y", inside='<mimic joint="a"/>'),
    )
    with pytest.raises(RobotError, match="in a circle"):
        load(tmp_path, arm(*more))


@pytest.mark.parametrize(
    ("filename", "place"),
    [
        ("package://my_arm/meshes/upper.obj", "my_arm/meshes/upper.obj"),
        ("package://my_arm/meshes/upper.obj", "meshes/upper.obj"),
        ("meshes/upper.obj", "my_arm/urdf/meshes/upper.obj"),
    ],
)
def test_meshes_are_found(tmp_path, filename, place):
    cube(tmp_path / place)
    folder = tmp_path / "my_arm" / "urdf"
    folder.mkdir(parents=True, exist_ok=True)
    shape = f'<mesh filename="{filename}"/>'
    robot = load(folder, arm(upper=inertial() + f"<collision><geometry>{shape}</geometry></collision>"))
    ball = [sf.Sphere(center=(0.25, 0, 0.15), radius=0.1)]
    assert robot.obstacles(ball).clearance([0, 0]) == pytest.approx(0.1, abs=1e-6)


def test_packages_are_found_in_the_ros_path(tmp_path, monkeypatch):
    cube(tmp_path / "ws" / "my_arm" / "upper.obj")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ws"))
    (tmp_path / "else").mkdir()
    shape = collision('<mesh filename="package://my_arm/upper.obj"/>')
    assert load(tmp_path / "else", arm(upper=inertial() + shape)).dof == 2


def test_pairs_that_touch_in_every_pose_are_neighbours(tmp_path):
    """A massless link without shape between two links: their shapes overlap wherever they go."""
    more = (
        link("mid"),
        link("hand", inertial() + '<collision><geometry><sphere radius="0.08"/></geometry></collision>'),
        joint("roll", "lower", "mid", axis="0 0 1"),
        joint("pitch", "mid", "hand", z=0),
    )
    robot = load(tmp_path, arm(*more))
    assert robot.self_clearance(np.zeros(4)) > 0


UNUSABLE = [
    ("<robot", "no readable XML"),
    ("", "no readable XML"),
    ("<html></html>", "root element is <html>"),
    (arm('<x:arm xmlns:x="http://www.ros.org/wiki/xacro"/>'), "xacro macros.* expand them first"),
    ("<mujoco><worldbody><bod/></worldbody></mujoco>", "unrecognized element.*'bod'"),
    ("<mujoco/>", "no joints that move"),
    (
        "<mujoco><worldbody><body><joint/></body><body name='b'><joint type='ball'/><geom size='.1'/></body>"
        "</worldbody></mujoco>",
        "ball joints",
    ),
    (arm(upper=inertial(-1)), "link upper has mass -1"),
    (arm(upper=inertial("heavy")), "mass of link upper is 'heavy'"),
    (arm(upper=inertial() + collision('<mesh filename="package://a/b.stl"/>')), "b.stl' of link upper was not found"),
    (arm(upper=inertial() + collision('<mesh filename="arm.dae"/>')), "link upper is of a kind .* expected .stl"),
    (arm(joint("x", "lower", "tool0", "wobbly")), "joint x is of type 'wobbly'"),
    (arm(joint("x", "lower", "nowhere")), "cannot use it"),
    (
        arm(joint("x", "lower", "tool0", inside='<mimic joint="elbow" multiplier="much"/>')),
        "'much'; expected a number",
    ),
    (arm(link("f"), joint("x", "lower", "f", inside='<mimic joint="ghost"/>')), "ghost"),
    (arm(link("f"), joint("elbow", "lower", "f")), "repeated name 'elbow'"),
    (arm().replace('lower="-1.5"', 'lower="2"', 1), "shoulder has limits from 2 to 1.5"),
    (arm().replace('lower="-1.5"', 'lower="nan"', 1), "not finite .jnt_range"),
    (arm().replace("0 0 0.2", "0 0 nan"), "numbers that are not finite"),
]


@pytest.mark.parametrize(("text", "message"), UNUSABLE)
def test_files_that_cannot_be_used_say_why(tmp_path, text, message):
    with pytest.raises(RobotError, match=message) as caught:
        load(tmp_path, text)
    assert "robot.urdf" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("given", ["kuka", "", b"lwr4", "robots/none.xml", "\0", 7, None, "~nobody_here/x.urdf"])
def test_unknown_robots_say_which_there_are(given):
    with pytest.raises(RobotError, match="jaco, lwr4, nao, planar_arm"):
        sf.Robot.load(given)


@given(text=st.text(alphabet='<>/="abcdejlmnorstuv 01', max_size=60), seed=st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_no_text_raises_anything_else(tmp_path_factory, text, seed):
    whole = arm()
    at = seed % len(whole)
    folder = tmp_path_factory.mktemp("hostile")
    for content in (text, whole[:at] + text + whole[at:], whole[:at]):
        try:
            load(folder, content)
        except SkillfoldError as error:
            assert str(error)


MJCF = """<mujoco model="mine">
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1"/>
    <body name="a" pos="0 0 0.5">{base}
      <geom size="0.05"/>
      <body name="b" pos="0.3 0 0"><joint name="turn" axis="0 1 0"/><geom name="ball" size="0.05" pos="0.3 0 0"/>
        <geom name="look" size="0.3" contype="0" conaffinity="0"/></body>
    </body>
    <body name="cup" pos="2 0 1"><freejoint/><geom size="0.1"/></body>
  </worldbody>
</mujoco>"""


def test_floors_and_loose_things_of_a_model(tmp_path):
    robot = load(tmp_path, MJCF.format(base=""), "mine.xml")
    assert robot.names == ("turn",)
    assert not robot.floating
    assert robot.space.kinds == ("continuous",)
    # Straight down the ball is 0.2 m above the floor; what only pleases the eye does not count, nor does the cup.
    assert robot.self_clearance([np.pi / 2]) == pytest.approx(0.15, abs=1e-9)
    np.testing.assert_allclose(robot.center_of_mass([0.0])[2], 0.5, atol=1e-12)


BOX = """<body name="box" pos="2 0 1"><freejoint/><geom size="0.1"/>
<body name="lid" pos="0 0 .2"><joint name="lid" axis="0 1 0"/><geom size="0.05"/></body>{more}</body>"""
TIED = '<equality><joint joint1="turn" joint2="lid"/><joint joint1="lid" joint2="turn"/></equality></mujoco>'


@pytest.mark.parametrize("first", [True, False])
def test_lids_of_loose_things_are_no_joints_of_the_robot(tmp_path, first):
    box, arm = BOX.format(more=""), MJCF.format(base="")
    mark, place = ("<worldbody>", f"<worldbody>{box}") if first else ("</worldbody>", f"{box}</worldbody>")
    text = arm.replace(mark, place)
    robot = load(tmp_path, text.replace("</mujoco>", TIED), "mine.xml")
    assert robot.names == ("turn",) and not robot.floating
    assert robot.notes == ("Not joints of the robot, as what carries them is loose: lid.",)
    assert robot.self_clearance([np.pi / 2]) == pytest.approx(0.15, abs=1e-9)
    np.testing.assert_allclose(robot.forward([0.3], "b"), load(tmp_path, arm, "mine.xml").forward([0.3], "b"))


def test_of_two_free_things_the_robot_has_more_joints(tmp_path):
    more = '<body><joint name="latch"/><geom size="0.05"/></body>'
    walker = MJCF.format(base="<freejoint/>")
    alone = load(tmp_path, walker.replace("<worldbody>", f"<worldbody>{BOX.format(more=more)}"), "mine.xml")
    assert alone.names == ("lid", "latch") and alone.floating and "turn" in alone.notes[0]


def test_a_free_base_stands_at_the_origin(tmp_path):
    robot = load(tmp_path, MJCF.format(base="<freejoint/>"), "mine.xml")
    assert robot.floating
    assert robot.names == ("turn",)
    np.testing.assert_allclose(robot.forward([0.0], "b"), [0.3, 0, 0, 1, 0, 0, 0], atol=1e-12)


def test_limits_that_mean_none_are_none(tmp_path):
    robot = load(tmp_path, arm().replace('lower="-1.5" upper="1.5"', 'lower="-1e16" upper="1e16"', 1))
    assert robot.space.kinds == ("continuous", "continuous")
    assert np.abs(robot.sample(100)).max() <= np.pi


def test_a_robot_without_names_says_what_it_wants(tmp_path):
    robot = load(tmp_path, '<mujoco><worldbody><body><joint/><geom size=".1"/></body></worldbody></mujoco>')
    with pytest.raises(InputError, match="give its tool one"):
        robot.forward([0.0])


def test_what_mujoco_warns_of_in_pythons_way_is_a_note(tmp_path):
    _, warned = loading._made("odd", lambda: warnings.warn("Strange\nrobot", stacklevel=1))
    assert warned == ["MuJoCo: Strange robot."]


def test_custom_limits_must_fit_the_joints(tmp_path):
    custom = '<custom><numeric name="velocity_limits" data="1 2 3"/></custom></mujoco>'
    with pytest.raises(RobotError, match="velocity_limits; expected 1 positive"):
        load(tmp_path, MJCF.format(base="").replace("</mujoco>", custom), "mine.xml")


def test_what_mujoco_warns_of_is_a_note_and_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    odd = arm(link("f"), joint("x", "lower", "f", inside='<mimic joint="ghost"/>'))
    spec, warned = loading._made("odd", lambda: mujoco.MjSpec.from_string(odd))
    assert len(spec.joints) == 3
    assert all(note.startswith("MuJoCo: ") for note in warned)
    assert list(tmp_path.iterdir()) == []
