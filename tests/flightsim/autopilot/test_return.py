"""Return and the geofence: neither its place nor its way is beyond the fence."""

import math

import pytest
import shapely

from flightsim.autopilot.fence_route import FenceRoutes, fence_routes
from flightsim.autopilot.modes import Mode
from flightsim.autopilot.results import CommandResult
from tests.flightsim.autopilot.bench import Bench

SQUARE = ((-20, -20), (-20, 20), (20, 20), (20, -20))
L_SHAPE = ((-5, -5), (25, -5), (25, 25), (15, 25), (15, 5), (-5, 5))
"""Home is in one leg, (20, 20) in the other; the straight way cuts the corner."""


def polygon(bench, command, corners):
    return [bench.item(command, e, n, param1=float(len(corners))) for e, n in corners]


def rally(bench, *places):
    bench.pilot.rally.replace([bench.item(5100, e, n, 5.0) for e, n in places])


def away_at(bench, east_m, north_m):
    bench.take_off()
    assert bench.pilot.goto(bench.geodetic(east_m, north_m)).is_accepted
    assert bench.run(40.0, lambda: math.dist(bench.position[:2], (east_m, north_m)) < 1.0)
    return bench


def returned(bench, fence, **limits):
    """Fly a return to the ground; whether it stayed within the fence all the way."""
    bench.positions.clear()
    bench.pilot.return_to_launch()
    assert bench.run(150.0, lambda: not bench.pilot.is_armed)
    shapely.prepare(fence)
    return bool(shapely.covers(fence, shapely.points(bench.positions)).all())


def test_a_rally_point_beyond_the_fence_is_told_and_not_used():
    bench = Bench(initial_parameters={"RTL_RETURN_ALT": 5})
    bench.pilot.fence.replace(polygon(bench, 5001, SQUARE))
    rally(bench, (28.0, 0.0))
    bench.run(0.1)
    assert bench.says("Rally point 0 is outside the geofence, not used")
    away_at(bench, 17.0, 0.0)
    assert returned(bench, shapely.Polygon(SQUARE))
    assert math.hypot(*bench.position[:2]) < 0.5


def test_a_fence_that_comes_later_is_held_against_the_rally_points():
    bench = Bench()
    rally(bench, (28.0, 0.0), (5.0, 5.0))
    bench.run(0.1)
    assert not bench.says("Rally point")
    bench.pilot.fence.replace(polygon(bench, 5001, SQUARE))
    bench.run(0.1)
    assert bench.says("Rally point 0 is outside")
    assert not bench.says("Rally point 1")


def test_a_return_flies_round_the_corner_of_a_fence():
    bench = Bench(initial_parameters={"RTL_RETURN_ALT": 5})
    bench.take_off()
    bench.pilot.goto(bench.geodetic(20.0, 20.0))
    assert bench.run(40.0, lambda: math.dist(bench.position[:2], (20.0, 20.0)) < 0.3)
    bench.pilot.fence.replace(polygon(bench, 5001, L_SHAPE))
    assert returned(bench, shapely.Polygon(L_SHAPE))
    assert math.hypot(*bench.position[:2]) < 0.5


def test_without_an_allowed_place_it_lands_where_it_is():
    bench = away_at(Bench(), 15.0, 0.0)
    bench.pilot.fence.replace([bench.item(5003, 15.0, 0.0, param1=8.0)])
    assert returned(bench, shapely.Point(15.0, 0.0).buffer(8.0))
    assert bench.says("no place within the geofence, landing here")
    assert math.dist(bench.position[:2], (15.0, 0.0)) < 1.5


def test_a_fence_that_is_off_or_ignored_changes_no_return():
    bench = Bench()
    bench.pilot.fence.replace(polygon(bench, 5001, SQUARE))
    assert fence_routes(bench.pilot._flight) is not None
    bench.pilot.fence.switch = False
    assert fence_routes(bench.pilot._flight) is None
    bench.pilot.fence.switch = True
    bench.pilot.parameters.set("GF_ACTION", 0)
    assert fence_routes(bench.pilot._flight) is None


@pytest.mark.parametrize("request_place", ["land", "takeoff", "orbit"])
def test_no_request_leads_beyond_the_fence(request_place):
    bench = away_at(Bench(), 5.0, 0.0)
    bench.pilot.fence.replace(polygon(bench, 5001, SQUARE))
    place = bench.geodetic(18.0, 0.0, 4.0)
    beyond = bench.geodetic(25.0, 0.0, 4.0)
    named = {"latitude_deg": beyond.latitude_deg, "longitude_deg": beyond.longitude_deg}
    replies = {
        "land": lambda: bench.pilot.land(**named),
        "takeoff": lambda: bench.pilot.takeoff(None, **named),
        "orbit": lambda: bench.pilot.orbit(place, radius_m=5.0, speed_mps=2.0),
    }
    reply = replies[request_place]()
    assert reply.result is CommandResult.DENIED
    assert "outside the uploaded fence" in reply.reason
    assert bench.pilot.mode is Mode.HOLD


def length_of(routes, start, goal):
    found = routes.length_and_route(start, goal)
    return None if found is None else found[0]


def test_the_shortest_way_round_an_exclusion():
    area = shapely.box(-50, -50, 50, 50).difference(shapely.box(-2, -20, 2, 5))
    length_m, route = FenceRoutes(area).length_and_route((-10.0, 0.0), (10.0, 0.0))
    assert len(route) == 3
    assert route[-1] == (10.0, 0.0)
    line = shapely.LineString([(-10.0, 0.0), *route])
    assert area.covers(line)
    # Over the upper corners, which it passes at 1.5 m.
    assert length_m == pytest.approx(2 * math.hypot(6.5, 6.5) + 7.0)


def test_a_place_that_cannot_be_reached_has_no_way():
    area = shapely.union_all([shapely.box(0, 0, 10, 10), shapely.box(20, 0, 30, 10)])
    routes = FenceRoutes(area)
    assert length_of(routes, (5.0, 5.0), (25.0, 5.0)) is None
    assert length_of(routes, (5.0, 5.0), (15.0, 5.0)) is None
    assert length_of(routes, (5.0, 5.0), (9.9, 9.9)) == pytest.approx(math.hypot(4.9, 4.9))


def test_from_beyond_it_comes_straight_back_first():
    routes = FenceRoutes(shapely.box(0, 0, 10, 10))
    _, (back, goal) = routes.length_and_route((15.0, 5.0), (5.0, 5.0))
    assert back == pytest.approx((9.25, 5.0))
    assert goal == (5.0, 5.0)


def test_a_fence_of_many_corners_is_searched_in_bounded_work():
    n = 480
    star = [
        (r * math.cos(math.tau * i / n), r * math.sin(math.tau * i / n))
        for i in range(n)
        for r in [50.0 if i % 2 else 20.0]
    ]
    routes = FenceRoutes(shapely.Polygon(star).difference(shapely.Point(0, 0).buffer(8.0)))
    found = routes.length_and_route((-12.0, 0.0), (12.0, 0.0))
    assert found is not None
