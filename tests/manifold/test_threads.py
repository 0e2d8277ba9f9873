"""Work shared among threads: all of it is done once, in order, and helpers never wait for each other."""

from threading import current_thread

import numpy as np
import pytest

from skillfold.manifold.threads import in_parts


@pytest.mark.parametrize("jobs", [1, 2, 3])
@pytest.mark.parametrize("count", [1, 31, 64, 100, 1000])
def test_every_row_once_in_order(count, jobs):
    found = in_parts(lambda part: np.arange(count)[part], count, jobs)
    assert 1 <= len(found) <= jobs
    np.testing.assert_array_equal(np.concatenate(found), np.arange(count))


def test_the_caller_does_a_part_itself():
    names = in_parts(lambda part: current_thread().name, 1000, 2)
    assert names[0] == current_thread().name
    assert names[1] != names[0]


def test_parts_of_parts():
    def whole(part):
        return sum(in_parts(lambda inner: inner.stop - inner.start, part.stop - part.start, 2))

    for _ in range(20):
        assert sum(in_parts(whole, 1000, 2)) == 1000


def test_an_error_in_a_part_is_the_caller_s():
    def work(part):
        if part.start > 0:
            raise ValueError("no such part")

    with pytest.raises(ValueError, match="no such part"):
        in_parts(work, 100, 2)
    assert in_parts(lambda part: part.start, 100, 2) == [0, 50]
