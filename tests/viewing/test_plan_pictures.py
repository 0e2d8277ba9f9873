"""Plans in one picture: of every kind of skill, among obstacles, failed ones too."""

from dataclasses import replace

import numpy as np
import pytest

import skillfold as sf
from skillfold.cli import main
from skillfold.errors import InputError, RobotError
from skillfold.experiments.reaching import inside_grid
from skillfold.experiments.three_link import REACHING, optimal
from skillfold.robots import rendering
from skillfold.viewing import plan_pictures
from skillfold.viewing.plan_pictures import along, draw_plan, phases_of, picture, shown_of
from skillfold.viewing.style import OFF

PHASE = np.linspace(0.0, 1.0, 50)


@pytest.fixture(scope="module")
def waves():
    demos = [np.column_stack([PHASE, np.sin(3 * PHASE) + shift]) for shift in (0.0, 0.04, -0.04)]
    return sf.SkillManifold.fit(demos, dim=1, kernels=5, ridge=1e-4)


@pytest.fixture(scope="module")
def arm():
    return sf.SkillManifold.fit(optimal(inside_grid(120, np.random.default_rng(5)), REACHING), dim=2, kernels=10)


def titles(made):
    return [ax.get_title(loc="left") for ax in made.axes if ax.get_title(loc="left")]


def test_recordings_of_the_plane(waves):
    obstacles = sf.PointObstacles([[0.5, 1.15]], 0.2)
    plan = waves.plan([0.0, 0.01], [1.0, 0.15], obstacles=obstacles)
    assert plan.success, plan.reason
    made = picture(waves, plan, obstacles)
    assert titles(made) == ["x0", "x1", "distance from the manifold; tolerance", "clearance; margin"]
    place, x0, _, distance, clearance = made.axes
    (ball,) = place.patches
    assert ball.radius == pytest.approx(0.1)
    np.testing.assert_allclose(place.lines[-3].get_xydata(), plan.path.states)
    assert len(x0.lines) == 3 + 1
    np.testing.assert_allclose(x0.lines[-1].get_ydata(), plan.path.states[:, 0])
    for ax, limit in ((distance, waves.tolerance), (clearance, obstacles.margin)):
        assert ax.lines[-1].get_ydata()[0] == pytest.approx(limit)
        assert ax.get_ylim()[0] <= ax.lines[0].get_ydata().min() <= ax.get_ylim()[1]


def test_part_of_the_way_stands_beside_its_part_of_the_demonstrations(waves):
    middle = shown_of(waves)[0][40]
    plan = waves.plan(middle, shown_of(waves)[0][-1])
    begin, end = phases_of(plan)
    assert 0.3 < begin < 0.5 and end == 1.0
    x0 = picture(waves, plan).axes[1]
    assert x0.lines[-1].get_xdata()[[0, -1]] == pytest.approx([begin, 1.0])


def test_coordinates_that_stand_still_show_no_rounding(arm):
    plan = arm.plan(*arm.sample(2, 1))
    still = np.array(plan.path.states)
    still[:, 2] = 1.0 + 1e-16 * np.arange(len(still))
    made = picture(arm, replace(plan, path=sf.Path(still)))
    low, high = made.axes[3].get_ylim()
    assert high - low > 0.01


def test_a_failed_plan_is_drawn_with_its_reason(waves, tmp_path):
    plan = waves.plan([0.0, 0.01], [1.0, 0.15], obstacles=sf.PointObstacles([[1.0, 0.15]], 0.3))
    assert not plan.success
    made = picture(waves, plan)
    assert [text.get_text() for text in made.texts][:2] == ["no plan", plan.reason[: plan_pictures.LONGEST]]
    assert made.texts[0].get_color() == OFF
    assert draw_plan(waves, plan, tmp_path / "failed.svg").read_text().startswith("<?xml")
    with pytest.raises(InputError, match="cannot be written"):
        draw_plan(waves, plan, tmp_path / "nowhere" / "plan.png")


@pytest.mark.parametrize(
    ("file", "obstacles", "told"),
    [
        ("plan.foo", None, "ends in .foo; possible: .png"),
        ("plan", None, "ends in nothing"),
        ("plan.png", [sf.Sphere([0.0, 0.0, 3.0], 0.1)], r"expected PointObstacles.* or robot.obstacles\(scene\)"),
        ("plan.png", sf.PointObstacles([[0.0, 0.0, 0.0]], 0.1), "states of 3 coordinates, the skill has 2"),
    ],
)
def test_what_cannot_be_drawn_is_told(waves, tmp_path, file, obstacles, told):
    plan = waves.plan([0.0, 0.01], [1.0, 0.15])
    with pytest.raises(InputError, match=told):
        draw_plan(waves, plan, tmp_path / file, obstacles)


def test_a_robot_is_drawn_in_its_scene(arm, monkeypatch):
    obstacles = sf.Robot.load("planar_arm").obstacles([sf.Sphere([0.0, -0.7, 0.0], 0.05)])
    plan = arm.plan(*arm.sample(2, 1), obstacles=obstacles)
    asked = []

    def shots(world, times, states, *_, marks):
        asked.append((states, marks[0][0].places))
        return iter([np.zeros((48, 64, 3), np.uint8)] * len(states))

    monkeypatch.setattr(rendering, "pictures", shots)
    made = picture(arm, plan, obstacles)
    assert sum(bool(ax.images) for ax in made.axes) == plan_pictures.POSES
    states, trace = asked[0]
    np.testing.assert_array_equal(states[[0, -1]], plan.path.states[[0, -1]])
    np.testing.assert_allclose(trace, obstacles.robot.forward(plan.path.states)[:, :3])


def test_where_nothing_can_be_rendered_the_rest_is_drawn_and_says_so(arm, monkeypatch):
    def nowhere(*_, **__):
        raise RobotError("No pictures: MuJoCo cannot draw off the screen here. Set MUJOCO_GL.")

    monkeypatch.setattr(rendering, "pictures", nowhere)
    obstacles = sf.Robot.load("planar_arm").obstacles()
    made = picture(arm, arm.plan(*arm.sample(2, 1), obstacles=obstacles), obstacles)
    assert "MUJOCO_GL" in made.texts[2].get_text()
    assert [ax.name for ax in made.axes].count("3d") == 1


def test_keyframes_have_no_manifold_to_be_off():
    robot = sf.Robot.load("jaco")
    pose = robot.forward(robot.home)
    way = np.stack([pose, pose + 0.1 * np.eye(7)[0]])
    skill = sf.KeyframeSkill.fit([way + 0.01 * i * np.eye(7)[1] for i in range(4)])
    obstacles = robot.obstacles()
    plan = skill.plan(robot, robot.home, obstacles, start_at=0)
    assert [curve.title for curve in along(skill, plan, obstacles)] == [*robot.names, "clearance; margin"]


@pytest.mark.parametrize(("name", "code"), [("plan.png", 0), ("plan.gif", 2)])
def test_the_command_line_draws_too(waves, tmp_path, capsys, name, code):
    waves.save(tmp_path / "skill.npz")
    ends = ("--start=0,0.01", "--goal=1,0.15")
    assert main(["plan", str(tmp_path / "skill.npz"), *ends, "--picture", str(tmp_path / name)]) == code
    assert (tmp_path / name).exists() == (code == 0)
    assert code == 0 or "possible: .png, .svg, .pdf" in capsys.readouterr().err
