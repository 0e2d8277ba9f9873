"""Free directions: found where there are some, and none made up where there are none."""

import numpy as np
import pytest

from manifold import clouds
from skillfold.experiments.synthetic import smooth_manifold
from skillfold.experiments.upright import LWR4, upright_poses
from skillfold.manifold.anchors import fit_surfaces
from skillfold.manifold.free import normal_spectrum, split_directions
from skillfold.manifold.free_slopes import bending, common_slope, without_slope

BENT = {
    "sphere": (clouds.draw_sphere, 2),
    "torus": (clouds.torus, 2),
    "circle in a plane of 3": (clouds.draw_circle, 1),
    "height": (clouds.draw_plane, 2),
    "two circles": (clouds.tori, 2),
    "sphere in 4": (clouds.sphere_of(4), 3),
    "sheet 2 in 4": (clouds.sheet(4, 2), 2),
    "sheet 3 in 5": (clouds.sheet(5, 3), 3),
}


@pytest.mark.parametrize("free", [1, 2, 3])
@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("dim", [None, "given"])
def test_the_lines_of_circle_times_lines_are_found(free, noise, dim):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        x, lines = clouds.cylinder(free)(500, rng)
        x = clouds.normalised(x + noise * rng.normal(size=x.shape))
        split, trials = split_directions(x, None, None if dim is None else 1 + free, 0)
        assert split.free.shape == (2 + free, free)
        assert split.dim == 1
        # Sine of the angle between the lines and what was found.
        assert np.linalg.norm(lines.T - split.free @ (split.free.T @ lines.T)) < 0.05
        basis = np.hstack([split.kept, split.free])
        np.testing.assert_allclose(basis.T @ basis, np.eye(2 + free), atol=1e-12)
        assert [t.setting for t in trials if t.choice == "free directions"] == [
            f"{free} of {2 + free} free, d = {1 + free}"
        ]


@pytest.mark.parametrize("seed", range(3))
def test_the_joints_that_an_upright_tool_leaves_free_are_found_exactly(seed):
    """The base's yaw and the last roll, from few samples with noise; local planes alone miss them by a fiftieth."""
    x = clouds.normalised(upright_poses(LWR4, 500, np.random.default_rng(seed)))
    split, _ = split_directions(x, None, None, 0)
    joints = np.eye(7)[:, [0, 6]]
    assert split.free.shape == (7, 2)
    assert np.linalg.norm(joints - split.free @ (split.free.T @ joints), axis=0).max() < 0.008


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_turn_off_the_free_directions_is_taken_back(noise):
    """Of a circle × two lines, from directions that are wrong by a thirtieth or so."""
    rng = np.random.default_rng(4)
    x, lines = clouds.cylinder(2)(400, rng)
    x = x + noise * rng.normal(size=x.shape)
    wrong = np.linalg.qr(np.hstack([lines.T + 0.03 * rng.normal(size=(4, 2)), rng.normal(size=(4, 2))]))[0]
    kept, free = without_slope(x, wrong[:, 2:], wrong[:, :2], 1, np.arange(400), 1)
    before, after = (np.linalg.norm(lines.T - f @ (f.T @ lines.T)) for f in (wrong[:, :2], free))
    assert before > 0.02
    assert after < 0.2 * before
    np.testing.assert_allclose(np.hstack([kept, free]).T @ np.hstack([kept, free]), np.eye(4), atol=1e-12)


def test_the_common_slope_of_a_sheared_sheet():
    """A parabola whose place and height both move with a third coordinate: sheared back in a few turns."""
    rng = np.random.default_rng(0)
    u, z = rng.uniform(-1, 1, (2, 300))
    left = np.array([0.02, -0.05])
    for _ in range(4):
        inner = np.column_stack([u, 0.3 * u**2]) + z[:, None] * left
        left = left - common_slope(inner, z[:, None], 1, np.arange(300), 1)[:, 0]
    assert np.abs(left).max() < 1e-4


@pytest.mark.parametrize("name", BENT)
@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03])
def test_nothing_is_free_where_everything_bends(name, noise):
    draw, dim = BENT[name]
    for seed in range(8):
        rng = np.random.default_rng(seed)
        x = draw(400, rng)
        x = clouds.normalised(x + noise * rng.normal(size=x.shape))
        split, trials = split_directions(x, None, None, 0)
        assert split.free.shape[1] == 0, f"seed {seed}"
        assert split.dim == dim, f"seed {seed}"
        assert not [t for t in trials if t.choice == "free directions"]


@pytest.mark.parametrize("name", ["sphere", "sheet 3 in 5"])
def test_nothing_is_free_where_the_dimension_is_given(name):
    draw, dim = BENT[name]
    for seed in range(4):
        x = clouds.normalised(draw(400, np.random.default_rng(seed)))
        split, _ = split_directions(x, None, dim, 0)
        assert (split.free.shape[1], split.dim) == (0, dim)


def test_few_samples_make_hardly_any_free_where_the_dimension_is_given():
    """A hundred samples of what bends a little everywhere: normals of so few touch some directions rarely."""
    made_up = []
    for seed in range(30):
        x = clouds.normalised(smooth_manifold(100, 7, 4, np.random.default_rng(seed)))
        made_up.append(split_directions(x, None, 4, 0)[0].free.shape[1])
    assert np.count_nonzero(made_up) <= 1


@pytest.mark.parametrize(("dim", "least"), [(None, 7), (3, 7)])
def test_directions_that_seem_free_besides_hide_none_that_is(dim, least):
    """A sheet that bends a little × a line: of normals that rarely touch two directions, one is free."""
    found = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        sheet, line = smooth_manifold(200, 5, 2, rng), rng.uniform(-1.0, 1.0, 200)
        turn = np.linalg.qr(rng.standard_normal((6, 6)))[0]
        x = clouds.normalised(np.column_stack([sheet, line]) @ turn.T)
        free = split_directions(x, None, dim, 0)[0].free
        found.append(free.shape[1] == 1 and np.abs(free[:, 0] @ turn[:, 5]) > 0.999)
    assert np.count_nonzero(found) >= least


def test_bending_tells_what_is_free_from_what_is_not():
    """A parabola × a plane, with noise; sheared by the square of a free coordinate it is none any more."""
    rng = np.random.default_rng(0)
    u, z = rng.uniform(-1, 1, 300), rng.uniform(-1, 1, (300, 2))
    inner = np.column_stack([u, 0.3 * u**2]) + 0.01 * rng.normal(size=(300, 2))
    assert 0.7 < bending(inner, z, 1, np.arange(300), 1) < 1.4
    assert bending(inner + 0.1 * z[:, 1:] ** 2 * [0, 1], z, 1, np.arange(300), 1) > 5.0
    assert bending(inner[:8], z[:8], 1, np.arange(8), 1) == np.inf
    # Without noise all that is left is rounding.
    assert bending(np.column_stack([u, np.zeros(300)]), z, 1, np.arange(300), 1) < 1.5


def test_bending_against_least_squares():
    """One neighbourhood, which is all samples: mean squares by nested fits."""
    rng = np.random.default_rng(1)
    u, z = rng.uniform(-1, 1, (2, 16))
    inner = np.column_stack([u, 0.3 * u**2 + 0.02 * z + 0.01 * rng.normal(size=16)])
    local = fit_surfaces(inner, inner[:1], np.argsort(np.linalg.norm(inner - inner[0], axis=1))[None], 1, 2)
    along, heights = ((inner - inner[0]) @ local.frames[0].T).T
    powers = np.column_stack([np.ones(16), along, along**2])
    rest = [
        np.linalg.lstsq(terms, heights, rcond=None)[1][0] for terms in (powers, np.column_stack([powers, z, z**2]))
    ]
    wanted = (rest[0] - rest[1]) / 2 / (rest[1] / 11)
    assert bending(inner, z[:, None], 1, np.array([0]), 1) == pytest.approx(wanted, rel=1e-6)


def test_recordings_are_judged_by_whole_recordings():
    """Straight strokes along a circle's axis, each at its own place on the circle."""
    rng = np.random.default_rng(0)
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    t = np.linspace(-1.5, 1.5, 30)
    strokes = [np.column_stack([np.full(30, np.cos(a)), np.full(30, np.sin(a)), t]) for a in angles]
    x = clouds.normalised(np.vstack(strokes) + 1e-3 * rng.normal(size=(720, 3)))
    split, _ = split_directions(x, np.repeat(np.arange(24), 30), 2, 0)
    np.testing.assert_allclose(np.abs(split.free), [[0.0], [0.0], [1.0]], atol=0.02)


def test_spectrum_of_a_plane_and_of_a_sphere():
    rng = np.random.default_rng(0)
    plane = np.column_stack([rng.uniform(-1, 1, (400, 2)), np.zeros(400)])
    touched, directions = normal_spectrum(plane, 1, 0)
    np.testing.assert_allclose(touched, [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(np.abs(directions[:, 2]), [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(normal_spectrum(clouds.draw_sphere(1000, rng), 1, 0)[0], 1 / 3, atol=0.06)


def test_same_seed_same_bits():
    x, _ = clouds.cylinder(2)(2500, np.random.default_rng(0))
    first, second = (split_directions(clouds.normalised(x), None, None, 4)[0] for _ in range(2))
    np.testing.assert_array_equal(first.free, second.free)
    np.testing.assert_array_equal(first.kept, second.kept)
