"""Scripts for MAVSDK, in the style of its published examples and in its native API."""

import pytest

pytestmark = pytest.mark.timeout(150)


@pytest.mark.parametrize(
    "script",
    [
        "grpc_takeoff_and_land.py",
        "grpc_goto.py",
        "grpc_mission.py",
        "grpc_offboard_position.py",
        "grpc_offboard_velocity.py",
        "grpc_shell.py",
    ],
)
def test_published_style_scripts_fly(script, testbench, run_script):
    run_script(script, testbench.sdk_address, str(testbench.sdk_server_port))


def test_the_native_api_flies(testbench, run_script):
    run_script("native_flight.py", testbench.sdk_address)
