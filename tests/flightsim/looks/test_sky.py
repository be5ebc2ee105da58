import numpy as np

from flightsim.cameras import Viewpoint
from flightsim.looks.light import AFTERNOON, light_of
from flightsim.looks.sky import fill_sky, painted_sky
from flightsim.looks.weather import parse_weather

TO_SUN = AFTERNOON.to_sun


def directions(n=4000):
    rays = np.random.default_rng(3).standard_normal((n, 3))
    rays[:, 2] = np.abs(rays[:, 2])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def test_sun_is_the_brightest_and_stands_where_light_comes_from():
    sky = painted_sky(directions()).sum(axis=1)
    sun = painted_sky(TO_SUN[None]).sum()
    assert sun > 2.85
    assert sun >= sky.max()


def test_sky_is_blue_with_clouds_in_it():
    rays = directions()
    # But for the sun and its glow.
    rgb = painted_sky(rays[(rays[:, 2] > 0.3) & (rays @ TO_SUN < 0.9)])
    assert (rgb[:, 2] >= rgb[:, 0] - 0.02).all()
    is_cloud = rgb[:, 0] > 0.7
    assert 0.02 < is_cloud.mean() < 0.5


def test_hills_close_the_horizon_and_land_lies_below():
    azimuth = np.linspace(0, 2 * np.pi, 721)
    level = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)

    def at(height):
        return painted_sky(np.column_stack([level, np.full(len(level), height)]))

    assert (at(0.008).sum(axis=1) < at(0.2).sum(axis=1).mean()).all()
    np.testing.assert_allclose(at(0.01)[0], at(0.01)[-1], atol=1e-3)
    below = at(-0.05)
    assert (below[:, 1] > below[:, 2]).all()


def test_pixels_without_a_surface_show_the_painted_sky_and_others_stay():
    # Level to the west: north is to the right.
    turn = np.column_stack([(0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)])
    view = Viewpoint(
        name="west",
        position_enu_m=np.zeros(3),
        rotation_enu_from_optical=turn,
        vertical_fov_rad=1.2,
    )
    rgb, depth_m = np.full((60, 80, 3), 7, np.uint8), np.full((60, 80), np.inf, np.float32)
    depth_m[50:] = 3.0
    fill_sky(rgb, depth_m, turn, view.focal_px(60))
    assert (rgb[50:] == 7).all()
    rays = view.rays_enu(80, 60)[:50].reshape(-1, 3)
    exact = 255 * painted_sky(rays / np.linalg.norm(rays, axis=1, keepdims=True))
    away = np.abs(exact.astype(int) - rgb[:50].reshape(-1, 3))
    assert np.median(away) <= 1
    assert np.quantile(away, 0.95) < 12


def test_straight_down_is_some_colour_too():
    rgb = np.zeros((1, 1, 3), np.uint8)
    down = np.diag([1.0, -1.0, -1.0])
    fill_sky(rgb, np.full((1, 1), np.inf, np.float32), down, 1.0)
    assert rgb.any()


def sky_of(text):
    return painted_sky(directions(), light_of(parse_weather(text), 47.4, 8.5).sky)


def test_sky_is_grey_under_clouds_and_dark_with_stars_at_night():
    overcast, night = sky_of("noon, overcast"), sky_of("night, clear")
    assert np.abs(overcast[:, 0] - overcast[:, 2]).max() < 0.2
    assert overcast.max() < 0.95
    assert np.median(night) < 0.15
    assert 0.001 < (night.min(axis=1) > 0.3).mean() < 0.03


def test_sun_sets_where_it_is_bright_at_dusk():
    colours = light_of(parse_weather("dusk, clear"), 47.4, 8.5).sky
    rays = np.stack([directions()[:, 0], directions()[:, 1], np.full(4000, 0.0)], axis=1)
    rays[:, 2] = 0.1 * np.linalg.norm(rays, axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    towards = rays @ np.array(colours.to_sun)
    sky = painted_sky(rays, colours).sum(axis=1)
    assert sky[towards > 0.9].mean() > sky[towards < 0.0].mean() + 0.15
