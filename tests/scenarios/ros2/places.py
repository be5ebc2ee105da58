"""Domain and port that no other process of the tests uses, and the transports that are there."""

from importlib.util import find_spec

import pytest

from tests.instances import own_instance


def domain():
    return 100 + own_instance()


def router_port():
    return 7447 + own_instance()


NEEDS_DDS = pytest.mark.skipif(
    find_spec("cyclonedds") is None, reason="Cyclone DDS has no wheel for Linux on ARM"
)
TRANSPORTS = (pytest.param("dds", marks=NEEDS_DDS), "zenoh")
