"""Light changes colours alone: depth, labels and lidar are the same to the bit in any light."""

from contextlib import closing

import numpy as np
import pytest

from flightsim.cameras import open_camera_renderer
from flightsim.lidars import Lidar, lidar_by_name
from flightsim.looks.light import light_of
from flightsim.looks.weather import parse_weather
from flightsim.plant import Plant, PlantCfg
from flightsim.testbench import TestbenchCfg
from flightsim.vehicles import airframe_by_name
from flightsim.world import build_world
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.flightsim.handmade import empty_scene, solid
from tests.instances import own_instance

SIZE_PX = (96, 72)
LIGHTS = (
    ("", "summer"),
    ("08:00, clear", "autumn"),
    ("overcast, fog 80 m", "spring"),
    ("night", "winter"),
)
STREET = (
    solid("box", (22.0, 0.0, 0.05), (40.0, 60.0, 0.1), material="asphalt"),
    solid("box", (9.0, -3.0, 4.0), (2.0, 5.0, 8.0), material="brick"),
    solid("box", (5.0, 5.0, 2.5), (0.15, 0.15, 5.0), material="metal"),
    solid("box", (5.0, 4.4, 4.9), (0.4, 0.4, 0.1), material="light_warm"),
)
"""A street with a house that throws a large shadow by day, and a lamp with a pool by night."""
EYE_ENU_M, TARGET_ENU_M = (-9.0, -9.0, 9.0), (5.0, 2.0, 0.0)


def street(text, season):
    light = light_of(parse_weather(text, season), 47.0, 8.0)
    return build_world(empty_scene(), airframe_by_name("iris"), extra=STREET, light=light)


def seen(backend, text, season):
    """Colours, and everything that light must leave as it is."""
    world = street(text, season)
    data = world.new_data()
    data.qpos[:3] = (-4.0, 3.0, 5.0)
    colours, rest = {}, {}
    with closing(open_camera_renderer(world, *SIZE_PX, backend)) as renderer:
        for camera in ("forward", "down"):
            frame = renderer.render(data, camera, 0)
            colours[camera], rest[f"{camera} depth"] = frame.rgb, frame.depth_m
            rest[f"{camera} depth alone"] = renderer.render_depth(data, camera, 0).depth_m
            rest[f"{camera} ids"] = renderer.render_ids(data, camera)
        # The vehicle is in view, with the translucent discs of its rotors.
        view = renderer.render_view(data, EYE_ENU_M, TARGET_ENU_M)
        colours["view"], rest["view depth"] = view.rgb, view.depth_m
        near = renderer.render_view(data, (-6.0, 3.0, 7.0), (-4.0, 3.0, 5.0))
        colours["near"], rest["near depth"] = near.rgb, near.depth_m
    return colours, rest


@pytest.mark.parametrize("backend", ["gl", "raycast"])
def test_depth_and_labels_are_the_same_in_any_light(backend):
    shots = [seen(backend, *light) for light in LIGHTS]
    first, rest = shots[0]
    for camera in ("forward", "down"):
        np.testing.assert_array_equal(rest[f"{camera} depth"], rest[f"{camera} depth alone"])
    for colours, other in shots[1:]:
        for name, values in rest.items():
            np.testing.assert_array_equal(other[name], values, err_msg=name)
        for name, rgb in colours.items():
            assert np.abs(rgb.astype(int) - first[name]).mean() > 5, name


def test_layers_have_the_colours_that_they_have_when_drawn_opaque():
    world = street("", "summer")
    data = world.new_data()
    data.qpos[:3] = (-4.0, 3.0, 5.0)
    with closing(open_camera_renderer(world, *SIZE_PX, "gl")) as renderer:
        layered = renderer.render(data, "forward", 0)
        stage = renderer._stages["fast"]
        assert not stage.has_opaque_layers
        stage._is_disc[:] = stage._model.geom_group == 0
        opaque = renderer.render(data, "forward", 0)
        assert stage.has_opaque_layers
    # The sum of two roundings is one step at most.
    assert np.abs(layered.rgb.astype(int) - opaque.rgb).max() <= 1
    np.testing.assert_array_equal(layered.depth_m, opaque.depth_m)


def test_lidars_scan_the_same_in_any_light():
    points = []
    for light in LIGHTS[::3]:
        plant = Plant(street(*light), PlantCfg(seed=2))
        lidar = Lidar(plant, lidar_by_name("vlp16"))
        while lidar.latest is None:
            plant.advance()
            lidar.update()
        points.append(lidar.latest.points_lidar_m)
    np.testing.assert_array_equal(*points)


def test_a_pilot_that_sees_depth_flies_the_same_in_any_light():
    flown = []
    for text in ("", "night, rain"):
        bench = TestbenchCfg(speed="max", instance=own_instance(), seed=3, light=text)
        # Without a given map the pilot sees by depth from the first second on.
        cfg = SitlCfg(scene="42", bench=bench, demo=True, map="onboard", headless_seconds=6.0)
        with Sitl(cfg, has_network=False) as sitl:
            flown.append(sitl.run().state_hash)
    assert flown[0] == flown[1]
