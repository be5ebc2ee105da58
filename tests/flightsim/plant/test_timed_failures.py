"""Parts fail at a moment of the flight that does not depend on who flies."""

import pytest

from flightsim.plant.timed_failures import TimedFailure, TimedFailureError, parse_failures
from flightsim.sensors.failure import Failure
from flightsim.testbench import Testbench, TestbenchCfg
from tests.flightsim.handmade import empty_scene


def test_words_name_part_kind_and_moment():
    assert parse_failures("none", 4) == ()
    assert parse_failures("gnss=off@5, motor2=stuck@8.5", 4) == (
        TimedFailure("gnss", None, Failure.OFF, 5.0),
        TimedFailure("motor", 2, Failure.STUCK, 8.5),
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("gnss", "PART=KIND@SECONDS"),
        ("gnss=off@-1", "PART=KIND@SECONDS"),
        ("wing=off@1", "part 'wing' is unknown; valid: gnss, "),
        ("motor5=off@1", "part 'motor5' is unknown; valid: .*motor1 to motor4"),
        ("motor=off@1", "part 'motor' is unknown"),
        ("gnss1=off@1", "part 'gnss1' is unknown"),
        ("motor1=garbage@1", "kind 'garbage' is unknown; valid: off, stuck, slow"),
        ("gnss=none@1", "kind 'none' is unknown"),
        ("gnss=off@1.2.3", "1.2.3 s is out of range; valid: 0 to 3600 s"),
        ("gnss=off@9999", "9999 s is out of range"),
    ],
)
def test_what_cannot_fail_is_refused_in_a_line(text, says):
    with pytest.raises(TimedFailureError, match=says) as caught:
        TestbenchCfg(fail=text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("waited_s", [0.0, 3.0])
def test_a_part_fails_so_long_after_lift_off(waited_s):
    """The moment counts from lift-off, however long the vehicle stood before."""
    cfg = TestbenchCfg(fail="gnss=off@1.5", speed="max")
    with Testbench(empty_scene(), cfg, has_network=False) as bench:
        plant, autopilot = bench.plant, bench.autopilot
        bench.run(10.0, until=lambda: autopilot.prearm.is_ok)
        bench.run(waited_s)
        ground_m = plant.truth.position_enu_m[2]
        assert autopilot.takeoff(bench.scene.altitude_m + 3.0).is_accepted
        assert autopilot.arm().is_accepted
        bench.run(10.0, until=lambda: plant.truth.position_enu_m[2] >= ground_m + 0.5)
        lifted_us = plant.time_us
        bench.run(10.0, until=lambda: plant._record["gnss"]["failure"][0] == Failure.OFF)
        assert plant.time_us - lifted_us == 1_500_000
