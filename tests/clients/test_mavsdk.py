"""Scripts for MAVSDK, in the style of its published examples and in its native API."""

import pytest

from tests.thorough import THOROUGH

pytestmark = pytest.mark.timeout(150)


@pytest.mark.parametrize(
    "script",
    [
        pytest.param("grpc_takeoff_and_land.py", marks=THOROUGH),
        "grpc_goto.py",
        "grpc_mission.py",
        pytest.param("grpc_offboard_position.py", marks=THOROUGH),  # examples do it too
        "grpc_offboard_velocity.py",
        "grpc_shell.py",
    ],
)
def test_published_style_scripts_fly(script, testbench, run_script):
    run_script(script, testbench.sdk_address, str(testbench.sdk_server_port))


def test_the_native_api_flies(testbench, run_script):
    run_script("native_flight.py", testbench.sdk_address)
