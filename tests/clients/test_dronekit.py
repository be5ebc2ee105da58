"""DroneKit, which knows ArduPilot alone."""

import pytest


@pytest.mark.timeout(300)
def test_dronekit_arms_takes_off_goes_flies_a_mission_and_returns(copter, run_script):
    run_script("dronekit_flight.py", f"tcp:127.0.0.1:{copter.tcp_port}")
