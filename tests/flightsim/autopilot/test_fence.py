import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from flightsim.autopilot.fence import FenceStore, PolygonFence, RallyStore
from flightsim.autopilot.mission_item import Cmd, MissionError, MissionFault, MissionItem
from flightsim.frames import Geodetic, LocalFrame

FRAME = LocalFrame(Geodetic(47.4, 8.5, 488.0))
SQUARE = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
coordinates = st.floats(-30.0, 30.0)


def item(command, east_m, north_m, param1=math.nan, frame=0):
    place = FRAME.geodetic_from_enu((east_m, north_m, 0.0))
    return MissionItem(
        frame=frame, command=command, param1=param1, x=place.latitude_deg, y=place.longitude_deg
    )


def polygon(vertices, command=Cmd.FENCE_POLYGON_INCLUSION):
    return [item(command, x, y, len(vertices)) for x, y in vertices]


def circle(x, y, radius_m, command=Cmd.FENCE_CIRCLE_INCLUSION):
    return [item(command, x, y, radius_m)]


def fence_of(*items):
    store = FenceStore(FRAME)
    store.replace([i for group in items for i in group])
    return store


def test_without_a_fence_everything_is_allowed():
    assert FenceStore(FRAME).allows((1e6, 0.0, 0.0))


@given(coordinates, coordinates)
def test_a_square_allows_its_inside(x, y):
    assume(abs(abs(x) - 10.0) > 1e-3 and abs(abs(y) - 10.0) > 1e-3)
    inside = abs(x) < 10.0 and abs(y) < 10.0
    assert fence_of(polygon(SQUARE)).allows((x, y, 5.0)) is inside
    excluded = fence_of(polygon(SQUARE, Cmd.FENCE_POLYGON_EXCLUSION))
    assert excluded.allows((x, y, 5.0)) is not inside


@given(coordinates, coordinates)
def test_the_direction_and_the_start_of_a_polygon_do_not_matter(x, y):
    polygons = [SQUARE, SQUARE[::-1], SQUARE[2:] + SQUARE[:2]]
    answers = {PolygonFence(p, is_inclusion=True).contains(x, y) for p in polygons}
    assert len(answers) == 1


def test_inclusions_add_up_and_exclusions_win():
    store = fence_of(
        circle(0.0, 0.0, 5.0),
        circle(20.0, 0.0, 5.0),
        circle(20.0, 0.0, 1.0, Cmd.FENCE_CIRCLE_EXCLUSION),
    )
    assert store.allows((0.0, 3.0, 1.0))
    assert store.allows((23.0, 0.0, 1.0))
    assert not store.allows((10.0, 0.0, 1.0))
    assert not store.allows((20.5, 0.0, 1.0))


def test_a_circle_of_no_radius_is_taken_as_by_px4_and_encloses_nothing():
    store = fence_of(polygon(SQUARE), circle(30.0, 0.0, 0.0))
    assert store.allows((5.0, 5.0, 1.0))
    assert not store.allows((30.0, 0.5, 1.0))


def test_a_radius_that_is_refused_is_none_of_the_valid_ones():
    with pytest.raises(MissionError, match=r"radius = -0.5 m; valid are 0 to 100000"):
        fence_of(circle(0.0, 0.0, -0.5))


@pytest.mark.parametrize(
    ("items", "fault", "index"),
    [
        (polygon(SQUARE)[:3], MissionFault.INVALID_SEQUENCE, 0),
        (polygon(SQUARE)[:3] + circle(0, 0, 5), MissionFault.INVALID_SEQUENCE, 3),
        (polygon(SQUARE[:2]), MissionFault.INVALID_PARAM, 0),
        (circle(0, 0, math.nan), MissionFault.INVALID_PARAM, 0),
        (circle(0, 0, -1.0), MissionFault.INVALID_PARAM, 0),
        (circle(math.nan, 0, 5.0), MissionFault.INVALID_PARAM, 0),
        ([item(Cmd.WAYPOINT, 0, 0)], MissionFault.UNSUPPORTED_COMMAND, 0),
        ([item(Cmd.FENCE_CIRCLE_INCLUSION, 0, 0, 5.0, frame=1)], MissionFault.UNSUPPORTED_FRAME, 0),
        (circle(0, 0, 5.0) * 501, MissionFault.NO_SPACE, None),
    ],
)
def test_a_bad_fence_is_refused_and_the_old_one_remains(items, fault, index):
    store = fence_of(polygon(SQUARE))
    with pytest.raises(MissionError) as caught:
        store.replace(items)
    assert (caught.value.fault, caught.value.index) == (fault, index)
    assert len(store) == 4
    assert not store.allows((20.0, 0.0, 0.0))


def test_rally_points_are_kept_in_metres_and_others_refused():
    store = RallyStore(FRAME)
    store.replace([item(Cmd.RALLY_POINT, 12.0, -3.0)])
    assert store.points_enu_m[0] == pytest.approx((12.0, -3.0), abs=1e-6)
    with pytest.raises(MissionError, match="5100"):
        store.replace([item(Cmd.WAYPOINT, 0.0, 0.0)])
    assert len(store) == 1
