"""The process pool: order, failures, early ends."""

import multiprocessing
import os
import signal
import time
from contextlib import closing
from functools import partial
from itertools import count

import pytest

from aeroscene import processes
from aeroscene.corpus.dataset import DatasetError
from aeroscene.processes import WorkerDiedError, Workers, default_jobs, run_all


def slow_square(number):
    time.sleep(0.02 * (number % 3))
    return number * number


def slow_process_id(_: int) -> int:
    time.sleep(0.05)
    return os.getpid()


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


def long_of(text, number):
    time.sleep(600 if number else 0)
    return len(text)


def test_leaving_early_ends_though_the_function_is_large():
    """More than a pipe holds, for every item that waits."""
    with Workers(partial(long_of, "x" * 200_000), count(), 2, 20) as results:
        assert next(results) == 200_000
    assert multiprocessing.active_children() == []


def large(_number):
    return bytes(50_000_000)


@pytest.mark.timeout(60)
def test_leaving_ends_where_a_process_is_killed_while_it_hands_over_a_result(monkeypatch):
    monkeypatch.setattr(processes, "_PATIENCE_S", 0.02)
    with Workers(large, count(), 2, 6) as results:
        next(results)
    assert multiprocessing.active_children() == []


def test_a_process_that_dies_is_said_in_a_line():
    with pytest.raises(WorkerDiedError, match="valid: fewer --jobs"):
        list(run_all(die, range(4), 2))


def mark(folder_and_number):
    folder, number = folder_and_number
    (folder / str(number)).touch()
    return number


def test_work_without_end_goes_so_far_ahead_and_no_farther(tmp_path):
    with Workers(mark, ((tmp_path, number) for number in count()), 2, 5) as results:
        assert [next(results) for _ in range(4)] == [0, 1, 2, 3]
        deadline_s = time.monotonic() + 60.0
        while len(list(tmp_path.iterdir())) < 9:
            assert time.monotonic() < deadline_s
            time.sleep(0.02)
        time.sleep(0.3)
        assert len(list(tmp_path.iterdir())) == 9
    assert multiprocessing.active_children() == []


def test_workers_leave_interrupts_to_the_parent():
    """As `timeout` and a terminal send them: to the whole group."""
    with Workers(slow_process_id, count(), 2, 2) as results:
        at_work: set[int] = set()
        while len(at_work) < 2:  # one that still starts is not ready for signals
            at_work.add(next(results))
        for process_id in at_work:
            os.kill(process_id, signal.SIGTERM)
            os.kill(process_id, signal.SIGINT)
        assert {next(results) for _ in range(6)} <= at_work
    assert multiprocessing.active_children() == []


def test_nothing_to_do_needs_no_process():
    assert list(run_all(die, (), 2)) == []
    assert default_jobs() >= 1
