"""Campaigns fly flight stacks that are not ours: kept apart by their builds, lost ones judged."""

import sys
from pathlib import Path

import pytest

from scenarios.campaigns.campaign import CampaignError, open_campaign, read_suite
from scenarios.campaigns.flight_stack import FlightStack, FlightStackError
from scenarios.campaigns.flyer import Flyer, Suite, Trial
from tests.instances import own_instance
from tests.scenarios.in_process import in_process

ROOT = Path(__file__).parents[3]


@pytest.fixture
def binary(tmp_path):
    """A stand-in for ArduPilot that ends after 0.2 s of flight."""
    path = tmp_path / "stand-in"
    path.write_text(
        f"#!{sys.executable}\n"
        f"import sys\nsys.path.insert(0, {str(ROOT)!r})\n"
        "from tests.flightsim.bridges import stand_in\nstand_in.main('exits')\n"
    )
    path.chmod(0o755)
    return path


@pytest.fixture
def suite(binary):
    return Suite(pilot="straight", stack=FlightStack(autopilot="ardupilot", binary=str(binary)))


def test_a_stack_that_is_lost_has_failed_its_trial_and_not_the_next(suite):
    with Flyer(suite, instance=own_instance()) as flyer:
        rows = [flyer.fly(Trial("field", "iris", number)) for number in range(2)]
    for row in rows:
        assert (row["success"], row["code"]) == (False, "hung")
        assert "ArduPilot's exit with status 3; its last line: last words" in row["reason"]
        assert row["sim_seconds"] == pytest.approx(0.2, abs=0.021)
        assert row["lockstep"]["told"] >= 99


def test_a_campaign_is_of_one_build(suite, binary, tmp_path):
    folder = tmp_path / "out"
    with open_campaign(folder, suite):
        pass
    assert read_suite(folder) == suite
    with (
        pytest.raises(CampaignError, match="holds a campaign with autopilot 'ardupilot' instead"),
        open_campaign(folder, Suite(pilot="straight")),
    ):
        pass
    binary.write_text(binary.read_text() + "# another build\n")
    with (
        pytest.raises(CampaignError, match="holds a campaign with autopilot_sha256"),
        open_campaign(folder, suite),
    ):
        pass
    binary.unlink()
    with (
        pytest.raises(FlightStackError, match=r"is no program; valid: that of ardupilot"),
        open_campaign(folder, suite),
    ):
        pass


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--autopilot", "px4"], "autopilot px4 needs --autopilot-binary"),
        (["--autopilot-binary", "px4"], "autopilot-binary 'px4' needs --autopilot"),
        (["--autopilot", "px4", "--autopilot-binary", "none"], "'none' is no program; valid: "),
        (
            ["--autopilot", "px4", "--autopilot-binary", "none", "--pilot", "mavlink"],
            "pilot mavlink flies by our autopilot, not px4; valid: another --pilot",
        ),
        (
            ["--autopilot", "px4", "--autopilot-binary", "none", "--engine", "ray"],
            "autopilot px4 flies on this machine; valid: --engine local",
        ),
        (
            ["--autopilot", "px4", "--autopilot-binary", "none", "--instance", "100"],
            "instance 100 is out of range",
        ),
    ],
)
def test_what_cannot_fly_is_one_line(capsys, tmp_path, options, line):
    status, _, err = in_process(capsys, "campaign", "--out", tmp_path / "out", *options)
    assert status == 2
    assert line in err
    assert len(err.splitlines()) == 1
