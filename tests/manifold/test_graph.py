import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import breadth_first_order, connected_components

from skillfold.errors import DisconnectedError
from skillfold.experiments.point_sets import draw_sphere
from skillfold.manifold.anchors import fit_surfaces
from skillfold.manifold.graph import align_frames, build_graph, nearest_pairs, temporal_pairs


def pieces(graph, n):
    return connected_components(graph.matrix(n), directed=False)[0]


def as_set(edges):
    return {tuple(sorted(edge)) for edge in edges.tolist()}


@pytest.mark.parametrize("neighbors", [1, 3, 8])
@pytest.mark.parametrize("seed", range(3))
def test_always_one_piece_with_each_edge_once(neighbors, seed):
    x = np.random.default_rng(seed).normal(size=(120, 3))
    graph = build_graph(x, neighbors)
    assert pieces(graph, 120) == 1
    assert len(as_set(graph.edges)) == len(graph.edges)
    assert (graph.edges[:, 0] < graph.edges[:, 1]).all()
    np.testing.assert_allclose(graph.lengths, np.linalg.norm(x[graph.edges[:, 0]] - x[graph.edges[:, 1]], axis=1))
    assert graph.median == np.median(graph.lengths)


def test_nearest_pairs_are_each_sample_s_nearest():
    x = np.random.default_rng(0).normal(size=(60, 2))
    gaps = np.linalg.norm(x[:, None] - x, axis=2)
    expected = {tuple(sorted((i, int(j)))) for i in range(60) for j in gaps[i].argsort()[1:6]}
    assert as_set(nearest_pairs(x, 5)) == expected


def test_consecutive_samples_of_a_recording_are_linked_and_no_others():
    groups = np.array([0, 0, 0, 1, 1, 2])
    np.testing.assert_array_equal(temporal_pairs(groups), [[0, 1], [1, 2], [3, 4]])


def test_temporal_links_are_kept_where_neighbours_would_not_make_them():
    """Two slow recordings and one fast one, whose own steps are longer than the way to the others."""
    slow = np.linspace(0, 1, 60)
    fast = np.linspace(0, 1, 5)
    x = np.vstack(
        [np.column_stack([slow, 0 * slow + y]) for y in (0, 0.02)] + [np.column_stack([fast, 0 * fast + 0.01])]
    )
    groups = np.r_[np.repeat([0, 1], 60), np.full(5, 2)]
    graph = build_graph(x, 3, groups)
    assert as_set(temporal_pairs(groups)) <= as_set(graph.edges)
    assert not as_set(temporal_pairs(groups)) <= as_set(nearest_pairs(x, 3))


def test_parts_near_each_other_are_joined_by_their_shortest_link():
    x = np.r_[np.linspace(0, 1, 50), np.linspace(1.1, 2.1, 50)][:, None] * [1.0, 0.0]
    graph = build_graph(x, 2)
    assert pieces(graph, 100) == 1
    assert {(49, 50)} == {edge for edge in as_set(graph.edges) if edge[0] < 50 <= edge[1]}


@pytest.mark.parametrize("gap", [20.0, 1e6])
def test_parts_far_from_each_other_are_named(gap):
    rng = np.random.default_rng(0)
    x = np.vstack([rng.uniform(size=(70, 2)), rng.uniform(size=(50, 2)) + gap, rng.uniform(size=(30, 2)) - gap])
    with pytest.raises(DisconnectedError, match=r"3 parts: 70 samples; 50 samples; 30 samples") as error:
        build_graph(x, 6)
    assert "10 times" in str(error.value)


def test_recordings_far_from_each_other_are_named():
    t = np.linspace(0, 1, 40)
    curves = [np.column_stack([t, t**2 + 0.01 * i]) for i in range(3)] + [np.column_stack([t + 50.0, t])]
    groups = np.repeat(np.arange(4), 40)
    with pytest.raises(DisconnectedError, match=r"120 samples \(demonstrations 0, 1, 2\); 40 samples .*3\)"):
        build_graph(np.vstack(curves), 6, groups)


def test_recordings_sampled_densely_are_no_parts():
    """Their own steps are far shorter than the way between them, and still they are one skill."""
    t = np.linspace(0, 1, 400)
    x = np.vstack([np.column_stack([t, np.full(400, y)]) for y in (0.0, 0.1, 0.2)])
    graph = build_graph(x, 6, np.repeat(np.arange(3), 400))
    assert pieces(graph, 1200) == 1


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), neighbors=st.integers(1, 10))
def test_a_permutation_of_a_cloud_permutes_the_graph(seed, neighbors):
    rng = np.random.default_rng(seed)
    x, order = rng.normal(size=(60, 3)), rng.permutation(60)
    graph, permuted = build_graph(x, neighbors), build_graph(x[order], neighbors)
    assert as_set(order[permuted.edges]) == as_set(graph.edges)


def test_rigid_motions_and_scales_leave_the_graph_as_it_is():
    rng = np.random.default_rng(0)
    x, turn = rng.normal(size=(100, 4)), np.linalg.qr(rng.normal(size=(4, 4)))[0]
    assert as_set(build_graph(100 * x @ turn.T + 7.0, 5).edges) == as_set(build_graph(x, 5).edges)


def test_aligned_frames_turn_within_their_planes_and_agree_with_a_neighbour():
    x = draw_sphere(300, np.random.default_rng(0))
    graph = build_graph(x, 8)
    neighbours = np.linalg.norm(x[:, None] - x, axis=2).argsort(1)[:, :20]
    frames = fit_surfaces(x, x, neighbours, 2, 2).tangents
    aligned = align_frames(frames, graph)
    for i in range(300):
        np.testing.assert_allclose(aligned[i] @ aligned[i].T, frames[i] @ frames[i].T, atol=1e-10)
    i, j = graph.edges.T
    gaps = np.linalg.norm(aligned[i] - aligned[j], axis=(1, 2))
    # A sphere cannot be combed: along its seam frames disagree, elsewhere hardly.
    assert np.median(gaps) < 0.5
    assert np.median(np.linalg.norm(frames[i] - frames[j], axis=(1, 2))) > 1.0


@pytest.mark.parametrize(("n_dims", "dim"), [(2, 1), (3, 2), (6, 4)])
def test_bases_are_turned_as_one_after_the_other_would_be(n_dims, dim):
    rng = np.random.default_rng(dim)
    x = rng.normal(size=(90, n_dims))
    graph = build_graph(x, 4)
    frames = np.linalg.qr(rng.normal(size=(90, n_dims, dim)))[0]
    order, parents = breadth_first_order(graph.matrix(90), 0, directed=False)
    expected = frames.copy()
    for i in order[1:]:
        u, _, vt = np.linalg.svd(frames[i].T @ expected[parents[i]])
        expected[i] = frames[i] @ u @ vt
    np.testing.assert_allclose(align_frames(frames, graph), expected, atol=1e-10)


def test_the_stride_is_from_place_to_place_however_many_samples_stand_about_each():
    places = np.outer(np.arange(30.0), [3.0, 4.0])
    for count in (1, 2, 7):
        trembling = 1e-3 * np.random.default_rng(0).normal(size=(30 * count, 2))
        graph = build_graph(np.repeat(places, count, axis=0) + trembling, 8)
        assert graph.stride(30 * count) == pytest.approx(5.0, rel=1e-2)
