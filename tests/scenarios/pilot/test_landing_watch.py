"""A landing area in a map that grows: what is free above it is seen while it is observed."""

import math

from flightsim.vehicles.catalogue import airframe_by_name
from scenarios.mission.surroundings import survey
from scenarios.pilot.landing_watch import FRAME_PERIOD_US, LandingWatch
from tests.autonomy.depth_scene import look_down
from tests.scenarios.landing_scenes import ON_LAWN, yard


def test_air_that_is_seen_to_be_free_from_above_the_area_may_be_descended_through():
    world = survey(yard(), airframe_by_name("iris"), map_source="onboard")
    x, y, z = ON_LAWN.centroid
    hover = (x, y, z + 4.0)
    for back_m in (4.0, 4.0, 2.0, 2.0):
        on_the_way = (x - back_m, y, hover[2])
        world.observe(look_down(on_the_way, pitch_down=math.radians(15.0)), on_the_way)
    watch = LandingWatch(world, ON_LAWN, hover)
    assert watch.choose() is None
    n_allowed = watch.is_allowed.sum()
    for n in range(6):
        image = look_down(hover)
        world.observe(image, hover)
        watch.fuse(n * FRAME_PERIOD_US, image)
    site = watch.choose()
    assert site is not None
    assert watch.is_allowed.sum() > 1.5 * n_allowed
    assert abs(site.position_enu_m[0] - x) < 0.3
