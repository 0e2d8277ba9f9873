"""Which pair of Gaussians a motion begins with."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keyframes.skills import pose, row
from skillfold.errors import InputError
from skillfold.keyframes.skill import KeyframeSkill


@pytest.fixture(scope="module")
def line():
    return KeyframeSkill.fit(row([0.0, 0.5, 1.0, 0.5], spread=0.02), 4)


@pytest.mark.parametrize(("x", "pair", "told"), [(0.0, 0, "inside Gaussian 0"), (1.0, 2, "inside Gaussian 2")])
def test_inside_a_gaussian_it_is_the_parent(line, x, pair, told):
    phase = line.phase(pose(x))
    assert (phase.pair, phase.done, phase.outside, phase.told) == (pair, False, 0.0, told)


def test_of_two_the_earlier(line):
    assert line.phase(pose(0.5)).pair == 1  # inside 1 and 3
    assert line.phase(pose(0.75)).pair == 1  # inside the envelopes 1 and 2


def test_inside_an_envelope(line):
    phase = line.phase(pose(0.25))
    assert phase.pair == 0 and "envelope of pair 0" in phase.told


def test_outside_of_all(line):
    phase = line.phase(np.array([0.25, 0.0, 5.0, 1, 0, 0, 0]))
    assert phase.pair == 0 and 4 < phase.outside < 5 and "outside every gate" in phase.told


def test_at_the_end_nothing_is_left():
    skill = KeyframeSkill.fit(row([0.0, 0.5, 1.0]))
    phase = skill.phase(pose(1.0))
    assert phase.done and phase.pair == 2 and "nothing is left" in phase.told


def test_override(line):
    assert line.phase(pose(0.0), start_at=2).pair == 2
    assert line.phase(pose(0.0), start_at=2).outside > 0.1
    for wrong in (-1, 3, 0.5, "1", True):
        with pytest.raises(InputError, match="start_at"):
            line.phase(pose(0.0), start_at=wrong)


def test_a_single_keyframe_has_no_pair():
    skill = KeyframeSkill.fit(row([0.0]), 1)
    assert skill.phase(pose(0.0)).done
    for where, start_at in ((5.0, None), (0.0, 0), (5.0, 0)):
        with pytest.raises(InputError, match="one keyframe"):
            skill.phase(pose(where), start_at)


def test_a_turn_counts(line):
    turned = np.append([0.0, 0, 0], Rotation.from_rotvec([1.0, 0, 0]).as_quat(scalar_first=True))
    assert line.phase(turned).outside > 0.05
