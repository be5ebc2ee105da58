"""The process pool: order, failures, early ends."""

import multiprocessing
import os
import signal
import time
from contextlib import closing

import pytest

from aeroscene.corpus.dataset import DatasetError
from scenarios.dataset.pool import WorkerDiedError, default_jobs, run_all


def slow_square(number):
    time.sleep(0.02 * (number % 3))
    return number * number


def refuse_three(number):
    if number == 3:
        raise DatasetError("three is refused")
    return number


def sleep_long(number):
    if number:
        time.sleep(600)
    return number


def die(number):
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_order(jobs):
    assert list(run_all(slow_square, range(20), jobs)) == [n * n for n in range(20)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_failure_keeps_its_type_and_what_came_before_it(jobs):
    results = run_all(refuse_three, range(9), jobs)
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(DatasetError, match="three is refused"):
        next(results)


def test_leaving_early_ends_the_processes():
    with closing(run_all(sleep_long, range(9), 2)) as results:
        assert next(results) == 0
        assert len(multiprocessing.active_children()) == 2
    assert multiprocessing.active_children() == []


def test_a_process_that_dies_is_said_in_a_line():
    with pytest.raises(WorkerDiedError, match="valid: fewer --jobs"):
        list(run_all(die, range(4), 2))


def test_nothing_to_do_needs_no_process():
    assert list(run_all(die, (), 2)) == []
    assert default_jobs() >= 1
