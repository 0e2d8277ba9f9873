"""Saved skills: back to the bit; a changed, cut or foreign file is refused as such."""

import json

import numpy as np
import pytest

from skillfold import SkillManifold
from skillfold.errors import SkillFileError


def test_everything_comes_back_to_the_bit(skill, tmp_path):
    path = tmp_path / "skill.npz"
    skill.save(path)
    back = SkillManifold.load(path)
    rng = np.random.default_rng(0)
    x = skill.sample(20, seed=1) + 0.05 * skill.model.scale * rng.normal(size=(20, skill.n_dims))
    for ask in (
        lambda s: s.tangent(x),
        lambda s: s.project(x),
        lambda s: s.project(x, near=x[::-1]),
        lambda s: s.project(x, method="leaf"),
        lambda s: s.distance(x),
        lambda s: s.distance_gradient(x),
        lambda s: s.inside(x),
        lambda s: s.contains(x),
        lambda s: s.sample(7, seed=3),
        lambda s: s.plan(x[0], x[1]).path.states,
        lambda s: s.plan(x[0], x[1], via=x[2:3], route="geodesic").path.states,
        lambda s: s.geodesic_distance(x[:2], x[2:4]),
    ):
        np.testing.assert_array_equal(ask(back), ask(skill))
    for name in ("space", "names", "selection", "noise", "residual", "ridge", "converged", "n_samples", "notes"):
        assert getattr(back, name) == getattr(skill, name)
    assert (back.dim, back.n_dims, back.kernels, back.tolerance) == (
        skill.dim,
        skill.n_dims,
        skill.kernels,
        skill.tolerance,
    )
    assert repr(back) == repr(skill)
    assert repr(back.plan(x[0], x[1])) == repr(skill.plan(x[0], x[1]))


def test_the_same_skill_gives_the_same_bytes(skill, tmp_path):
    skill.save(tmp_path / "a.npz")
    SkillManifold.load(tmp_path / "a.npz").save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_numpy_reads_the_arrays(saved, recorded):
    with np.load(saved, allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["points"], recorded.model.surface.points)
        assert json.loads(str(archive["header"]))["kind"] == "skill manifold"


def test_every_flipped_byte_is_noticed(saved):
    data = bytearray(saved.read_bytes())
    places = sorted({*range(0, len(data), 1997), *range(100), *range(len(data) - 100, len(data))})
    for place in places:
        for flip in (0x01, 0xFF):
            data[place] ^= flip
            saved.write_bytes(data)
            with pytest.raises(SkillFileError):
                SkillManifold.load(saved)
            data[place] ^= flip
    saved.write_bytes(data)
    SkillManifold.load(saved)


def test_every_truncation_and_extension_is_noticed(saved):
    data = saved.read_bytes()
    cuts = sorted({*range(0, len(data), 1999), *range(100), *range(len(data) - 100, len(data))})
    for cut in cuts:
        saved.write_bytes(data[:cut])
        with pytest.raises(SkillFileError):
            SkillManifold.load(saved)
    for extra in (b"\0", b"more", data):
        saved.write_bytes(data + extra)
        with pytest.raises(SkillFileError):
            SkillManifold.load(saved)


def test_messages_name_the_file_and_what_is_wrong(saved, tmp_path):
    data = saved.read_bytes()
    saved.write_bytes(data[:-1])
    with pytest.raises(SkillFileError, match=r"skill\.npz: damaged, cut short"):
        SkillManifold.load(saved)
    with pytest.raises(SkillFileError, match=r"none\.npz: cannot be read"):
        SkillManifold.load(tmp_path / "none.npz")
    with pytest.raises(SkillFileError, match="cannot be read"):
        SkillManifold.load(tmp_path)


def test_a_file_that_cannot_be_written_is_named(recorded, tmp_path):
    for path in (tmp_path, tmp_path / "no" / "folder.npz"):
        with pytest.raises(SkillFileError, match="cannot be written"):
            recorded.save(path)


def test_recordings_are_no_skill(tmp_path):
    np.savez(tmp_path / "arrays.npz", states=np.zeros((3, 2)))
    with pytest.raises(SkillFileError, match="not saved by skillfold"):
        SkillManifold.load(tmp_path / "arrays.npz")
