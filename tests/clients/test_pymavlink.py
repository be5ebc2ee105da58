"""Plain pymavlink over TCP."""

import pytest


@pytest.mark.timeout(150)
def test_a_mission_is_uploaded_and_flown_over_tcp(testbench, run_script):
    run_script("pymavlink_flight.py", f"tcp:127.0.0.1:{testbench.tcp_port}")
