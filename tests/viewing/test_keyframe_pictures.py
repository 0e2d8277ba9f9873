"""Pictures of keyframe tasks: what is drawn is where it should be, with and without scenes."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from skillfold.errors import RobotError
from skillfold.experiments import keyframe_cost, keyframe_demo, keyframes
from skillfold.experiments.rows import Settings
from skillfold.robots.shapes import Box
from skillfold.viewing import envelope_pictures, keyframe_costs, keyframe_paths, keyframe_pictures


@pytest.fixture(scope="module")
def story():
    return keyframe_demo.run(0, plans=1)


def test_a_picture_of_both_tasks(story, tmp_path):
    path, note = keyframe_pictures.draw(story, tmp_path / "keyframes.png")
    assert path.stat().st_size > 20_000 and (note == "" or "MUJOCO_GL" in note)


def test_where_nothing_can_be_drawn_off_screen_the_paths_remain(story, monkeypatch, tmp_path):
    def fail(chapter):
        raise RobotError("No pictures.")

    monkeypatch.setattr(keyframe_pictures, "scene", fail)
    path, note = keyframe_pictures.draw(story, tmp_path / "keyframes.png")
    assert path.exists() and note.startswith("No pictures.")


def test_paths_in_space(story, tmp_path):
    assert keyframe_paths.draw(story, tmp_path / "paths.png").stat().st_size > 20_000
    for shape in (s for chapter in story.chapters for s in chapter.learnt.task.scene):
        low, high = keyframe_paths._rims(shape)
        size = shape.size if isinstance(shape, Box) else (2 * shape.radius, 2 * shape.radius, shape.length)
        assert np.allclose(np.ptp(np.vstack([low, high]), axis=0), size)
        assert np.allclose(0.5 * (low + high).mean(axis=0), np.array(shape.pose)[:3])


def test_facts_are_of_every_task_and_alpha(story):
    facts = story.facts()
    assert [(f["task"], f["alpha"]) for f in facts] == [
        ("pick and drop", 100.0),
        ("pick and drop", 85.0),
        ("pick and place", 100.0),
        ("pick and place", 85.0),
    ]
    assert all(f["outside"] == f["touching"] == 0 and f["states"] > 0 for f in facts)


def test_edges_of_the_tree_end_where_others_begin(story):
    edges = keyframe_pictures.tree_edges(story.chapters[0])
    root = story.chapters[0].learnt.task.robot.forward(story.chapters[0].start)[:3]
    starts, ends = np.array([e[0] for e in edges]), np.array([e[-1] for e in edges])
    known = np.vstack([root, ends])
    assert len(edges) > 0 and all(np.abs(known - start).sum(axis=1).min() < 1e-9 for start in starts)


def test_shadows_hold_what_is_inside(story):
    envelope = story.chapters[0].learnt.envelope
    made = Figure()
    plane = envelope_pictures.view(20.0, -60.0)
    assert np.allclose(plane @ plane.T, np.eye(2))
    ax = made.add_subplot()
    envelope_pictures.shadow(ax, envelope, plane, rings=True)
    seen = envelope.sample(200, 0)[:, :3] @ plane.T
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    assert ((seen > [left, low]) & (seen < [right, high])).all()


def test_outlines_lie_on_the_ellipsoid():
    root = np.random.default_rng(0).standard_normal((3, 3))
    mean, covariance, axis = np.arange(3.0), root @ root.T, np.array([1.0, 2.0, 3.0])
    for ring in (*envelope_pictures.principal(mean, covariance), envelope_pictures.section(mean, covariance, axis)):
        away = ring - mean
        assert np.allclose(np.einsum("ni,ij,nj->n", away, np.linalg.inv(covariance), away), 1.0)
    assert np.allclose((envelope_pictures.section(mean, covariance, axis) - mean) @ axis, 0.0)


def test_pictures_of_envelopes_and_costs(tmp_path, monkeypatch):
    monkeypatch.setattr(keyframe_cost, "LIMITS", {"paper": 0.2, "mended": 5.0})
    skills = keyframes.learn(Settings(3), 1)[:1]
    assert keyframe_costs.draw_envelopes(skills, tmp_path / "a.png").stat().st_size > 20_000
    found = keyframe_cost.run(skills, Settings(3), 2)
    rows = keyframe_cost.rows(found)
    assert [row.name.split(", ")[1] for row in rows] == ["as printed"] * 4 + ["mended"] * 4
    assert [row.unit for row in rows] == ["ms", ""] * 4 and all(row.measured > 0 for row in rows)
    assert all(runs.inside == 1.0 for runs in found if runs.variant == "mended")
    assert keyframe_costs.draw_costs(found, tmp_path / "b.png").stat().st_size > 10_000
