"""The surface's own tangents against their twin on random models, and paths that are solved with them."""

from dataclasses import replace

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import frames, geodesic, relax, scratch_memory
from manifold.random_models import SHAPES, random_model


def room(model, n):
    return frames.make_frames(model.surface, len(model.field.weights), n)


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(29, *request.param)


def crossed(field):
    """The same field, but across the surface: its rows are turned by a quarter toward the next coordinate."""
    return field._replace(weights=np.ascontiguousarray(np.roll(field.weights, 1, axis=1)))


def on_surface(model, count):
    anchors = model.surface.points.T
    return anchors[model.rng.choice(len(anchors), count, replace=len(anchors) < count)]


def test_follow_surface(model):
    """Twice: the frame of the first time is turned on."""
    states = model.states(7, 0.1)
    scratch, kept = scratch_memory.make_scratch(model.table, 7), room(model, 7)
    before = [model.surface.tangents[twins.nearest(model.surface.points, x)[0][0]] for x in states]
    for time in range(2):
        scratch_memory.evaluate(states, scratch)
        frames.follow_surface(model.surface, states, time == 0, scratch, kept)
        found = [twins.follow_surface(model.surface, x, frame) for x, frame in zip(states, before, strict=True)]
        for i, (normal, basis, frame) in enumerate(found):
            np.testing.assert_allclose(scratch.normals[i], normal, atol=1e-8)
            np.testing.assert_allclose(scratch.bases[i], basis, atol=1e-7)
            np.testing.assert_allclose(kept.frames[i], frame, atol=1e-10)
        before = [frame for _, _, frame in found]


def test_tangents_do_not_depend_on_the_field(model):
    """Nor do displacements: it may lie across the surface."""
    states, found = model.states(5, 0.05), []
    for field in (model.field, crossed(model.field)):
        turned = replace(model, field=field)
        scratch, kept = scratch_memory.make_scratch(turned.table, 5), room(model, 5)
        scratch_memory.evaluate(states, scratch)
        frames.follow_surface(model.surface, states, True, scratch, kept)
        found.append((scratch.normals.copy(), scratch.bases.copy()))
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-12)
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-12)


@pytest.mark.parametrize("rate", [1.0, 0.5])
def test_relax_with_them(model, rate):
    for start, goal in zip(on_surface(model, 3), on_surface(model, 3), strict=True):
        path = np.linspace(start, goal, 9)
        scratch = scratch_memory.make_scratch(model.table, 9)
        expected, *told = twins.relax(model.surface, model.field, path, 0.0, 0.3, 4, 0.5, True, rate)
        found = relax(path, 0.0, 0.3, 4, 0.5, True, rate, scratch)
        assert found[0] == told[0]
        np.testing.assert_allclose(path, expected, atol=1e-5)


def test_solve_geodesic_with_them_where_the_field_lies_across():
    """A bent sheet whose field is turned by a quarter: the field's own equations lead nowhere."""
    model = random_model(31, 3, 2, 40, 8, 2)
    anchors = model.surface.points.T
    far = int(np.linalg.norm(anchors - anchors[0], axis=1).argmax())
    first, path = np.stack([anchors[0], anchors[far]]), np.empty((20, 3))
    first = np.linspace(first[0], first[1], 5)
    iterations, moved = geodesic.solve_geodesic(model.table, first, 0.1, path, 1e-9, 0.3, 100, True, 1.0)
    assert iterations < 100
    assert moved < 1e-9
    frame = [model.surface.tangents[twins.nearest(model.surface.points, x)[0][0]] for x in path]
    for _ in range(60):
        found = [twins.follow_surface(model.surface, x, f) for x, f in zip(path, frame, strict=True)]
        frame = [f for _, _, f in found]
    normals, bases = np.array([f[0] for f in found]), np.array([f[1] for f in found])
    normals[[0, -1]] = 0.0
    assert np.abs(twins.newton_steps(path, normals, bases)).max() < 1e-6
