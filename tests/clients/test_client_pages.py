"""The scripts of docs/clients, run as they stand right after the start of the testbench."""

import pytest

from tests.clients.conftest import run_page


@pytest.mark.timeout(150)
@pytest.mark.parametrize("page", ["mavsdk.md", "pymavlink.md"])
def test_a_script_of_a_page_takes_off_and_lands(testbench, page):
    above, landed = run_page(f"clients/{page}", testbench)
    assert above.endswith("m above the start")
    assert landed == "landed"


@pytest.mark.timeout(150)
def test_the_script_for_dronekit_flies_to_a_place_as_with_ardupilot(copter):
    above, landed = run_page("clients/dronekit.md", copter)
    assert above.endswith("m above the start")
    assert landed == "landed"
