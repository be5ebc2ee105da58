"""Processes that fly: none of what a pilot does to one stops the campaign."""

import multiprocessing
import sys
from multiprocessing import forkserver

import pytest

from scenarios.campaigns.engines.crew import Crew, WorkerError
from scenarios.campaigns.engines.local import LocalEngine
from scenarios.campaigns.flyer import Suite, Trial
from tests.thorough import THOROUGH

pytestmark = pytest.mark.timeout(600)
STUBS = "tests.scenarios.campaigns.stub_pilots"
TWO = [Trial("49", "iris", 0), Trial("49", "iris", 1)]
TWO_VEHICLES = [Trial("49", "iris", 0), Trial("49", "hummingbird", 0)]


def rows_of(pilot, trials=TWO, n_workers=1, patience_s=500.0):
    engine = LocalEngine(Suite(pilot=f"{STUBS}:{pilot}"), patience_s)
    with Crew(engine, n_workers, patience_s) as crew:
        return {row["trial_id"]: row for row in crew.fly(trials)}


@pytest.fixture
def output(capfd):
    """What processes print; those of a server that began before this test would print elsewhere."""
    forkserver._forkserver._stop()
    yield lambda: capfd.readouterr().out
    forkserver._forkserver._stop()


def test_two_processes_fly_what_one_flies():
    alone, together = rows_of("Idle"), rows_of("Idle", n_workers=2)
    assert {key: row["state_hash"] for key, row in alone.items()} == {
        key: row["state_hash"] for key, row in together.items()
    }
    assert [row["code"] for row in alone.values()] == ["never_flew", "never_flew"]
    assert multiprocessing.active_children() == []


def test_a_pilot_that_ends_its_process_fails_after_another_try():
    rows = rows_of("Dying", TWO[:1])
    assert [row["code"] for row in rows.values()] == ["died"]
    assert rows["49/iris/0"]["reason"] == "its process ended with -9, twice"


@THOROUGH  # only the number of its end differs
def test_a_pilot_that_leaves_politely_has_failed_too():
    rows = rows_of("Leaving", TWO[:1])
    assert rows["49/iris/0"]["reason"] == "its process ended with 0, twice"


@pytest.mark.skipif(sys.platform != "linux", reason="no bound on memory there")
def test_a_pilot_that_floods_memory_or_output_harms_nobody(output):
    rows = rows_of("Troubled", TWO_VEHICLES)
    assert [row["code"] for row in rows.values()] == ["raised", "raised"]
    assert "MemoryError" in rows["49/iris/0"]["reason"]
    assert rows["49/hummingbird/0"]["reason"] == "SystemExit: enough"
    assert "blah" not in output()


def test_a_process_that_ends_once_costs_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("DYING_ONCE", str(tmp_path / "mark"))
    rows = rows_of("DyingOnce")
    assert (tmp_path / "mark").exists()
    assert [row["code"] for row in rows.values()] == ["never_flew", "never_flew"]


def test_a_pilot_that_hangs_fails_and_the_next_trial_is_flown():
    rows = rows_of("Hanging", patience_s=5.0)
    assert [row["code"] for row in rows.values()] == ["hung", "hung"]
    assert rows["49/iris/0"]["reason"] == "no end in 5 s"
    assert multiprocessing.active_children() == []


def test_what_no_process_can_do_is_said_in_a_line():
    with pytest.raises(WorkerError, match="has no attribute 'Nobody'; valid: demo"):
        rows_of("Nobody")
    assert multiprocessing.active_children() == []
