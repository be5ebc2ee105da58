"""Ray flies the trials that this machine's own processes fly."""

import subprocess

import psutil
import pytest

from scenarios.campaigns.engines.cluster import ray_engine
from scenarios.campaigns.engines.crew import Crew
from scenarios.campaigns.engines.local import LocalEngine
from scenarios.campaigns.flyer import Suite, Trial

# Ray is not imported here: it reads where it may listen when it is.
pytestmark = [pytest.mark.timeout(600), pytest.mark.filterwarnings("ignore")]
STUBS = "tests.scenarios.campaigns.stub_pilots"
TRIALS = [Trial("7", vehicle, 0) for vehicle in ("iris", "hummingbird")]


def outcomes(engine, trials=TRIALS):
    with Crew(engine, 2, patience_s=100.0) as crew:
        rows = list(crew.fly(trials))
    return {row["trial_id"]: (row["code"], row["reason"], row.get("state_hash")) for row in rows}


def test_ray_flies_what_local_processes_fly_and_leaves_nothing_behind():
    suite = Suite(pilot="straight")
    local = outcomes(LocalEngine(suite, 100.0))
    assert all(state_hash for _, _, state_hash in local.values())
    others = set(psutil.Process().children(recursive=True))
    with ray_engine(suite, 100.0, 2) as engine:
        started = set(psutil.Process().children(recursive=True)) - others
        heard = {c.laddr.ip for p in started for c in p.net_connections() if c.status == "LISTEN"}
        assert outcomes(engine) == local
        assert subprocess.run(["false"], check=False).returncode == 1
    assert heard <= {"127.0.0.1", "::1", "::ffff:127.0.0.1"}
    assert not psutil.wait_procs(started, timeout=60.0)[1]


def test_a_pilot_that_ends_its_process_fails_after_another_try():
    suite = Suite(pilot=f"{STUBS}:Dying")
    with ray_engine(suite, 100.0, 2) as engine:
        rows = outcomes(engine, TRIALS[:1])
    assert {code for code, _, _ in rows.values()} == {"died"}


def test_a_program_that_ends_with_an_error_is_told_from_one_that_leaves():
    with ray_engine(Suite(pilot="mavlink", program="false"), 100.0, 1) as engine:
        rows = outcomes(engine, TRIALS[:1])
    assert {code for code, _, _ in rows.values()} == {"raised"}
