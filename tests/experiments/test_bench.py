"""Rows, groups and the small machinery of the benchmark."""

import json

import numpy as np
import pytest

from skillfold.baselines.pose_optimiser import optimise_poses
from skillfold.errors import InputError, SkillfoldError
from skillfold.experiments import bench, three_link
from skillfold.experiments.alone import alone, import_seconds
from skillfold.experiments.reaching import inside_grid
from skillfold.experiments.rows import Row
from skillfold.experiments.synthetic import noisy_sphere, smooth_manifold


def test_a_row_knows_whether_its_target_is_met():
    assert Row("a", 1.0, target=1.0).met is True
    assert Row("a", 1.0, target=1.0, comparison="<").met is False
    assert Row("a", 2.0, target=2.0, comparison="==").met is True
    assert Row("a", 0.9, target=0.95, comparison=">=").met is False
    assert Row("a", None, target=1.0).met is None
    assert Row("a", 1.0).met is None
    assert Row("a", float("nan"), target=1.0).met is False


def test_unknown_group_names_those_there_are():
    with pytest.raises(InputError, match="speed"):
        bench.run(["velocity"])


def test_report_goes_through_json(monkeypatch):
    told = []
    monkeypatch.setitem(bench.GROUPS, "arm", (_experiment,))
    report = bench.run(["arm", "arm"], seed=7, progress=lambda label, share: told.append((label, share)))
    back = json.loads(json.dumps(report.as_dict()))
    assert back["seed"] == 7
    assert back["rows"] == [Row("seed", 7.0, target=8.0, group="arm").as_dict()]
    assert told == [("measuring", 0.0)]
    assert set(back["machine"]["packages"]) == set(bench.PACKAGES)


def test_seeds_are_fresh_by_default(monkeypatch):
    monkeypatch.setitem(bench.GROUPS, "arm", (_experiment,))
    assert bench.run(["arm"]).seed != bench.run(["arm"]).seed


def test_alone_returns_the_answer_and_the_memory():
    answer = alone("builtins", "dict", a=1)
    assert answer["a"] == 1
    assert 0.005 < answer["peak_memory_gb"] < 1


def test_alone_reports_failure():
    with pytest.raises(SkillfoldError, match="no_such"):
        alone("skillfold.experiments.alone", "no_such")


def test_import_seconds_is_a_time():
    assert 0 < import_seconds("json") < 5


def test_synthetic_samples():
    rng = np.random.default_rng(0)
    x = smooth_manifold(200, 7, 4, rng)
    assert x.shape == (200, 7)
    centred = noisy_sphere(5000, 0.01, rng)
    assert np.std(np.linalg.norm(centred, axis=1)) == pytest.approx(0.01, rel=0.1)


def test_pose_optimiser_finds_the_optimal_poses():
    rng = np.random.default_rng(0)
    ends = inside_grid(2, rng)
    positions = np.linspace(*ends, 20)
    truth = three_link.optimal(positions, three_link.REACHING)
    cost = three_link.REACHING
    poses, succeeded = optimise_poses(
        positions, truth[0], cost.cost, cost.gradient, three_link.forward, three_link.jacobian
    )
    assert succeeded == 1.0
    np.testing.assert_allclose(poses, truth, atol=1e-2)


def _experiment(settings):
    settings.progress("measuring", 0.0)
    return [Row("seed", float(settings.seed), target=8.0)]
