from contextlib import closing

import numpy as np
import pytest

from aeroscene.sources import load_scene
from flightsim.cameras import open_camera_renderer
from flightsim.looks.light import light_of
from flightsim.looks.weather import parse_weather
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world

SIZE_PX = (96, 72)
EYE, TARGET = (-8.0, -8.0, 5.0), (10.0, 10.0, 0.0)


@pytest.fixture(scope="module", params=["gl", "raycast"])
def backend(request):
    return request.param


def frame(backend, text, season="summer", time_s=0.0, eye=EYE):
    scene = load_scene("field")
    light = light_of(parse_weather(text, season), scene.latitude_deg, scene.longitude_deg)
    world = build_world(scene, airframe_by_name("iris"), light=light)
    data = world.new_data()
    data.time = time_s
    with closing(open_camera_renderer(world, *SIZE_PX, backend)) as renderer:
        return renderer.render_view(data, eye, TARGET)


def test_light_and_weather_change_no_depth(backend):
    plain = frame(backend, "")
    for text, season in (("night, fog 60 m", "summer"), ("snow", "winter"), ("08:00", "autumn")):
        other = frame(backend, text, season)
        np.testing.assert_array_equal(other.depth_m, plain.depth_m)
        assert np.abs(other.rgb.astype(int) - plain.rgb).mean() > 10


def test_contrast_at_the_visibility_is_a_fiftieth(backend):
    clear, foggy = (frame(backend, f"overcast, {haze}") for haze in ("fog 50 km", "fog 20 m"))
    # A picture of a long way: everything farther than the visibility is of one colour.
    far = np.isfinite(clear.depth_m) & (clear.depth_m > 25.0)
    near = clear.depth_m < 9.0
    spread = foggy.rgb[far].astype(float).std(axis=0)
    assert (spread < 6.0).all()
    assert np.abs(foggy.rgb[near].astype(float) - foggy.rgb[far].mean(axis=0)).mean() > 12.0


def test_rain_falls_by_the_clock_and_alike_every_time(backend):
    first, again, later = (frame(backend, "rain", time_s=t).rgb for t in (1.0, 1.0, 1.1))
    np.testing.assert_array_equal(first, again)
    assert (first != later).any()
