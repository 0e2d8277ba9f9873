"""`KeyframeSkill`: what it is learnt from, what it tells, and what it refuses."""

import warnings
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from keyframes.skills import demonstrations, pose, row
from skillfold.demonstrations import Demonstrations
from skillfold.errors import InputError

POSE = ["x", "y", "z", "qw", "qx", "qy", "qz"]
TRUTH, DEMOS = demonstrations(11, missing=0.1, extra=0.1)


@pytest.fixture(scope="module")
def skill():
    return sf.KeyframeSkill.fit(DEMOS)


def test_what_it_tells(skill):
    assert skill.n_keyframes == len(skill.gaussians) == 4
    assert TRUTH.holds(2, skill.gaussians[2].mean)
    assert skill.gaussians[0].covariance.shape == (6, 6)
    assert [len(labels) for labels in skill.labels] == [len(demo) for demo in DEMOS]
    for k, gaussian in enumerate(skill.gaussians):
        assert gaussian.count == sum(int((labels == k).sum()) for labels in skill.labels)
    assert skill.extras == sum(map(len, DEMOS)) - sum(g.count for g in skill.gaussians)
    assert max(skill.selection, key=lambda found: found[1])[0] == 4
    for word in ("4 Gaussians", "7 demonstrations", "97.5 %", " m and ", " rad"):
        assert word in repr(skill)


def test_it_is_frozen(skill):
    with pytest.raises(FrozenInstanceError):
        skill.coverage = 0.5
    for array in (*skill.keyframes, skill.gaussians[0].mean):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_every_form_of_the_same_keyframes(tmp_path):
    demos = row([0.0, 0.3, 0.5])
    wanted = [g.mean for g in sf.KeyframeSkill.fit(demos).gaussians]
    recordings = Demonstrations(demos, names=POSE)
    recordings.save(tmp_path / "keyframes.csv")
    more = Demonstrations([np.column_stack([np.arange(3), d]) for d in demos], names=["step", *POSE])
    capitals = Demonstrations(demos, names=[name.upper() for name in POSE])
    for form in (np.array(demos), tuple(demos), recordings, more, capitals, tmp_path / "keyframes.csv"):
        found = sf.KeyframeSkill.fit(form)
        np.testing.assert_allclose([g.mean for g in found.gaussians], wanted, atol=1e-12)


def test_files_may_leave_keyframes_out_and_repeat_them(tmp_path):
    """What arrays may, files may too; full recordings must move."""
    demos = row([0.0, 0.5])
    demos[1], demos[2] = demos[1][:1], demos[2][[0, 0, 1]]
    demos[4] = demos[4][[1, 1]]
    wanted = [g.mean for g in sf.KeyframeSkill.fit(demos, 2).gaussians]
    lines = [",".join(map(repr, [i, *pose.tolist()])) for i, demo in enumerate(demos) for pose in demo]
    (tmp_path / "few.csv").write_text("\n".join(["demo," + ",".join(POSE), *lines]))
    np.savez(tmp_path / "few.npz", **{f"states_{i}": demo for i, demo in enumerate(demos)}, names=POSE)
    for name in ("few.csv", "few.npz"):
        found = sf.KeyframeSkill.fit(tmp_path / name, 2)
        np.testing.assert_allclose([g.mean for g in found.gaussians], wanted, atol=1e-12)
        with pytest.raises(InputError, match="1 samples; expected two"):
            sf.KeyframeSkill.fit(tmp_path / name, 2, extract=True)


def test_full_recordings():
    """Keyframes from rests and turns, or from where the gripper closes."""
    corners = row([0.0, 0.4, 0.1], spread=0.005)
    phase = np.linspace(0, 1, 40, endpoint=False)[:, None]
    recordings = []
    for demo in corners:
        path = np.vstack([demo[0] + phase * (demo[1] - demo[0]), demo[1] + phase * (demo[2] - demo[1]), demo[2]])
        recordings.append(np.column_stack([path, np.where(np.arange(81) < 20, 0.0, 1.0)]))
    demos = Demonstrations(recordings, names=[*POSE, "gripper"])
    turned = sf.KeyframeSkill.fit(demos, extract=True)
    np.testing.assert_allclose([g.mean[0] for g in turned.gaussians], [0.0, 0.4, 0.1], atol=0.03)
    closed = sf.KeyframeSkill.fit(demos, gripper="gripper")
    np.testing.assert_allclose([g.mean[0] for g in closed.gaussians], [0.0, 0.2, 0.1], atol=0.03)
    with pytest.raises(InputError, match="possible: gripper"):
        sf.KeyframeSkill.fit(demos, gripper="grip")
    with pytest.raises(InputError, match="possible: gripper"):
        sf.KeyframeSkill.fit(demos, gripper="x")


def test_envelopes(skill):
    envelope = skill.envelope(1)
    assert envelope.parent is skill.gaussians[1] and envelope.child is skill.gaussians[2]
    assert skill.envelope(1, alpha=60).alpha == 60
    assert sf.KeyframeSkill.fit(row([0.0, 0.3]), interpolation="bures").envelope(0).interpolation == "bures"
    for wrong in (3, -1, 0.0, "0", None, True):
        with pytest.raises(InputError, match="there are 3"):
            skill.envelope(wrong)


def test_coverage_widens_gates():
    narrow, wide = (sf.KeyframeSkill.fit(row([0.0, 0.3]), coverage=c).gaussians[0].gates for c in (0.8, 0.99))
    assert (narrow < wide).all()


def test_assign(skill):
    rng = np.random.default_rng(2)
    new = [TRUTH.draw(k, rng) for k in (0, 2, 3)]
    np.testing.assert_array_equal(skill.assign(new), [0, 2, 3])
    far = np.array([5.0, 5, 5, 1, 0, 0, 0])
    np.testing.assert_array_equal(skill.assign([new[0], far, new[1]]), [0, -1, 2])
    assert (skill.assign([new[1], TRUTH.draw(1, rng)]) >= 0).sum() == 1  # in order


def test_refined(skill):
    _, more = demonstrations(11)
    better = skill.refined(more)
    assert len(better.keyframes) == 14 and better.n_keyframes == 4
    assert len(set(better.names)) == 14 and better.names[:7] == skill.names
    assert (better.gaussians[0].gates < skill.gaussians[0].gates).all()
    again = sf.KeyframeSkill.fit([*DEMOS, *more])
    for a, b in zip(better.gaussians, again.gaussians, strict=True):
        np.testing.assert_array_equal(a.covariance, b.covariance)


def test_same_seed_same_bits(skill):
    again = sf.KeyframeSkill.fit(DEMOS)
    for a, b in zip(skill.gaussians, again.gaussians, strict=True):
        np.testing.assert_array_equal(np.append(a.mean, a.covariance), np.append(b.mean, b.covariance))


def test_the_order_of_demonstrations_does_not_matter(skill):
    other = sf.KeyframeSkill.fit(DEMOS[::-1])
    for a, b in zip(skill.gaussians, other.gaussians, strict=True):
        np.testing.assert_allclose(a.mean, b.mean, atol=1e-12)
        np.testing.assert_allclose(a.covariance, b.covariance, atol=1e-12)


def test_few_keyframes_are_told():
    with pytest.warns(UserWarning, match=r"Gaussian \d was learnt from 2 keyframes"):
        skill = sf.KeyframeSkill.fit(row([0.0, 0.3], demos=2))
    assert len(skill.notes) == 2


def test_millimetres_are_told():
    long = [demo * np.r_[1000.0, 1000.0, 1000.0, np.ones(4)] for demo in row([0.1, 0.3])]
    with pytest.warns(UserWarning, match="m from the origin; positions are in metres"):
        sf.KeyframeSkill.fit(long)


def test_half_turns_are_told():
    with pytest.warns(UserWarning, match="Gaussians 0 and 1 are about half a turn apart"):
        skill = sf.KeyframeSkill.fit(row([0.0, 0.3], angles=[0.0, np.pi - 0.01]))
    with pytest.raises(InputError, match="turned 179°"):
        skill.envelope(0)


HOSTILE = {
    "a number": (3, "list of arrays"),
    "nothing": (None, "list of arrays"),
    "one array": (np.zeros((3, 7)), "list of arrays"),
    "an empty list": ([], "no demonstrations"),
    "one demonstration": (row([0.0, 0.3])[:1], "two at least"),
    "positions alone": ([np.zeros((2, 3))] * 2, r"shape \(2, 3\)"),
    "no keyframes": ([np.zeros((0, 7))] * 2, "expected keyframes"),
    "no number": ([[[np.nan] * 7]] * 2, "not finite"),
    "text": ([["left"]] * 2, "expected"),
    "no unit quaternions": ([np.ones((2, 7))] * 2, "length 2"),
    "full recordings": ([np.tile(pose(0.0), (31, 1))] * 2, "extract=True"),
    "far away": ([[[1e9, 0, 0, 1, 0, 0, 0]]] * 2, "beyond"),
    "other coordinates": (Demonstrations([np.eye(3), np.eye(3)], names=["a", "b", "c"]), "expected x, y, z, qw"),
    "no such file": ("nowhere.csv", "no such file"),
}


@pytest.mark.parametrize(("given", "said"), HOSTILE.values(), ids=HOSTILE)
def test_keyframes_that_cannot_be_used(given, said):
    with pytest.raises(InputError, match=said):
        sf.KeyframeSkill.fit(given)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.lists(st.integers(1, 4), min_size=2, max_size=4), st.floats(-9, 5))
def test_any_keyframes_give_a_skill(seed, counts, size):
    """However few, near or far: Gaussians that hold their own keyframes, or a word on why not."""
    rng = np.random.default_rng(seed)
    demos = [np.hstack([10**size * rng.normal(size=(m, 3)), rng.normal(size=(m, 4))]) for m in counts]
    demos = [np.hstack([d[:, :3], d[:, 3:] / np.linalg.norm(d[:, 3:], axis=1, keepdims=True)]) for d in demos]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        found = sf.KeyframeSkill.fit(demos)
    assert found.n_keyframes >= 1 and all(g.count >= 1 for g in found.gaussians)
    assert all(np.isfinite(score) for _, score in found.selection)
    for demo, labels in zip(found.keyframes, found.labels, strict=True):
        places = labels[labels >= 0]
        assert (np.diff(places) > 0).all() and len(labels) == len(demo)


OPTIONS = {
    "n_keyframes": [0, -1, 99, 2.0, "3", True],
    "coverage": [0.0, 1.0, "x", None],
    "interpolation": ["cubic", None, 3],
    "seed": [-1, 0.5, None, "0", 2**32],
    "gripper": ["gripper", 3],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name in OPTIONS for value in OPTIONS[name]])
def test_options_that_cannot_be_used(name, value):
    with pytest.raises(InputError, match=name):
        sf.KeyframeSkill.fit(DEMOS, **{name: value})


def test_more_keyframes_than_places():
    """Whatever is asked for, each Gaussian has keyframes, or it is told."""
    same = [np.tile(pose(0.1), (4, 1))] * 3
    try:
        found = sf.KeyframeSkill.fit(same, 4)
    except InputError as error:
        assert "places" in str(error)
    else:
        assert all(g.count for g in found.gaussians)
