"""How many processes a command starts that was not told."""

import os

import pytest

from tactiledata.cli.task_options import MOST_WORKERS, VARIABLE, workers_of
from tactiledata.errors import UsageError


@pytest.fixture(autouse=True)
def untold(monkeypatch):
    """The environment says nothing."""
    monkeypatch.delenv(VARIABLE, raising=False)


@pytest.mark.parametrize(("cores", "workers"), [(1, 1), (2, 2), (MOST_WORKERS, MOST_WORKERS), (64, MOST_WORKERS)])
def test_one_process_for_each_processor_up_to_a_limit(monkeypatch, cores, workers):
    """Processors that this process may not use do not count; memory is bounded on large machines."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(cores)))
    assert workers_of(None) == workers


def test_what_is_typed_goes_before_the_environment(monkeypatch):
    """The option, then the variable; beside a cluster nothing runs here, whatever the variable says."""
    monkeypatch.setenv(VARIABLE, "7")
    assert workers_of(3) == 3
    assert workers_of(None) == 7
    assert workers_of(None, "tcp://here:1") == 1
    assert workers_of(2, "tcp://here:1") == 2


@pytest.mark.parametrize("told", ["0", "-1", "many", "1.5"])
def test_a_variable_that_is_no_number_is_refused(monkeypatch, told):
    """It is said what stands there, and what to do."""
    monkeypatch.setenv(VARIABLE, told)
    with pytest.raises(UsageError, match=f"{VARIABLE}='{told}' in the environment"):
        workers_of(None)


def test_an_empty_variable_says_nothing(monkeypatch):
    """A blank TACTILEDATA_WORKERS counts as unset: there is one process for each processor, up to the limit."""
    monkeypatch.setenv(VARIABLE, " ")
    assert workers_of(None) == min(len(os.sched_getaffinity(0)), MOST_WORKERS)
