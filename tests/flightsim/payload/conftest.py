"""The empty field of the tests of MAVLink."""

from tests.flightsim.mavlink.conftest import field

__all__ = ["field"]
