"""Falls in a yard made by hand."""

import math
from dataclasses import replace

import pytest

from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.dataset.falling_vehicle import FallingVehicle
from tests.scenarios.landing_scenes import ON_CONTAINER, ON_LAWN, yard


@pytest.fixture(scope="module")
def vehicle():
    return FallingVehicle(yard(), airframe_by_name("iris"))


@pytest.mark.parametrize("area", [ON_CONTAINER, ON_LAWN], ids=["container", "lawn"])
@pytest.mark.parametrize("yaw_rad", [0.0, 2.0])
def test_on_level_ground_it_comes_to_rest_where_it_fell(vehicle, area, yaw_rad):
    fall = vehicle.fall(area, yaw_rad)
    assert fall.rested
    assert fall.inside_m == pytest.approx(area.radius, abs=0.05)
    assert fall.height_m == pytest.approx(0.0, abs=0.01)
    assert fall.tilt_rad < math.radians(0.5)


def test_a_claim_in_the_air_is_seen_in_the_height(vehicle):
    x, y, z = ON_CONTAINER.centroid
    area = replace(ON_CONTAINER, centroid=(x, y, z + 1), polygon=raised(ON_CONTAINER, 1.0))
    assert vehicle.fall(area, 0.0).height_m == pytest.approx(-1.0, abs=0.02)


def test_a_claim_across_an_edge_is_seen_in_tilt_or_place(vehicle):
    # The centroid lies on the container's edge: half of the legs find nothing.
    edge_y = 1.2
    shift = edge_y - ON_CONTAINER.centroid[1]
    area = replace(
        ON_CONTAINER,
        centroid=(9.0, edge_y, ON_CONTAINER.centroid[2]),
        polygon=tuple((x, y + shift, z) for x, y, z in ON_CONTAINER.polygon),
    )
    fall = vehicle.fall(area, 0.0)
    assert fall.height_m < -0.3 or fall.tilt_rad > math.radians(5)


def raised(area, by_m):
    return tuple((x, y, z + by_m) for x, y, z in area.polygon)


def test_the_height_over_a_sloping_claim_is_measured_along_its_normal(vehicle):
    # Level ground that calls itself a slope through the centroid: touched in the middle.
    polygon = tuple((x, y, z + 0.1 * (x - 9.0)) for x, y, z in ON_LAWN.polygon)
    fall = vehicle.fall(replace(ON_LAWN, polygon=polygon, slope_rad=math.atan(0.1)), 0.0)
    assert fall.height_m == pytest.approx(0.0, abs=0.02)
