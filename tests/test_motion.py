import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.motion import Path, Plan, Trajectory


def test_a_path_knows_its_length_and_keeps_a_copy():
    corners = np.array([[0.0, 0], [3, 4], [3, 5]])
    path = Path(corners, ("x", "y"))
    corners[0] = 9
    assert path.length == 6 and len(path) == 3
    assert path.states[0].tolist() == [0, 0]
    with pytest.raises(ValueError, match="read-only"):
        path.states[0, 0] = 1


@pytest.mark.parametrize("states", [[1.0, 2.0], [[np.nan, 1.0]], [[np.inf, 1.0]]])
def test_a_path_is_a_table_of_finite_numbers(states):
    with pytest.raises(InputError, match="states: expected 2 dimensions of finite numbers"):
        Path(states)


def test_a_trajectory_has_a_rising_time_for_each_state():
    assert len(Trajectory([0, 1], [[0.0], [1]]).times) == 2
    with pytest.raises(InputError, match="2 times for 1 states"):
        Trajectory([0, 1], [[0.0]])
    with pytest.raises(InputError, match="increase"):
        Trajectory([0, 0], [[0.0], [1]])
    with pytest.raises(InputError, match="times: expected 1 dim"):
        Trajectory([[0, 1]], [[0.0], [1]])


@pytest.mark.parametrize(("success", "verdict"), [(True, "success"), (False, "failure")])
def test_a_plan_tells_its_story(success, verdict):
    plan = Plan(success, "Way found.", Path([[0.0], [1]]), 1.0, 1e-3, 7, True)
    assert f"Plan({verdict}: Way found. 2 states, length 1, residual 0.001, 7 iterations)" == repr(plan)
    assert plan.stats == {} and plan.stats is not Plan(True, "", plan.path, 1, 0, 1, True).stats
