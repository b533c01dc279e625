"""Linear algebra on one thread while a block runs."""

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from tactiledata.compute.local import LocalScheduler
from tactiledata.compute.threads import one_thread


def threads():
    """Numbers of threads of the libraries that multiply matrices, after one product."""
    np.ones((4, 4)) @ np.ones((4, 4))
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


def test_a_block_has_one_thread_and_what_follows_as_many_as_before():
    """Two threads become one inside the block, and two again after it, after an error as well."""
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        with one_thread():
            assert set(threads()) == {1}
        assert threads() == before
        with pytest.raises(ValueError, match="planted"), one_thread():
            raise ValueError("planted")
        assert threads() == before


def most_threads(size):
    """The largest number of threads of linear algebra in a task, which asked for as many as there are."""
    np.ones((size, size)) @ np.ones((size, size))
    return max(threads())


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_task_has_one_thread(workers, monkeypatch):
    """A task has one thread, in this process and in workers; outside of tasks this process has as many as before."""
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    with threadpool_limits(limits=2, user_api="blas"):
        assert [one.result for one in LocalScheduler(workers).outcomes(most_threads, [4, 5, 6])] == [1, 1, 1]
        assert max(threads()) == 2
