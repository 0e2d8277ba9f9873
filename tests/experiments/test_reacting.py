"""The rows about the controller's speed and safety."""

import numpy as np
import pytest

from skillfold.experiments import reacting, tray
from skillfold.experiments.rows import Settings


@pytest.fixture(scope="module")
def rows():
    return reacting.measure(Settings(11), steps=60, cases=2)


def test_every_figure_is_measured_and_has_a_target(rows):
    assert [row.unit for row in rows] == ["µs", "µs", "share", "ms", "ms"]
    assert all(row.measured > 0 and row.target is not None for row in rows)
    assert all("0 without success" in row.note for row in rows[3:])


def test_hostile_samples_are_answered_by_holding(rows):
    assert rows[2].measured == 1.0
    assert all(name in rows[2].note for name in reacting.HOSTILE)


def test_a_crowded_scene_has_ten_boxes_and_leaves_the_path_clear(rows):
    rng = np.random.default_rng(3)
    case = reacting.past_boxes(1, rng)[0]
    scene = reacting.crowded(case.scene, case.oracle, rng)
    assert len(scene) == reacting.BOXES
    assert tray.arm().obstacles(scene).clearance(case.oracle).min() > 0
