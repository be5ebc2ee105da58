import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from flightsim.cameras import look_at
from flightsim.cameras.framing import frame_points

FOV_RAD = math.radians(40)
points = st.lists(
    st.tuples(*[st.floats(-60, 60)] * 2, st.floats(0, 30)), min_size=2, max_size=12
).map(np.array)


@given(points, st.floats(-3, 3), st.floats(0.2, 1.4))
def test_all_points_are_in_the_picture_and_fill_it(places, azimuth_rad, elevation_rad):
    eye, target = frame_points(
        places,
        azimuth_rad=azimuth_rad,
        elevation_rad=elevation_rad,
        vertical_fov_rad=FOV_RAD,
        aspect=4 / 3,
    )
    view = look_at(eye, target, FOV_RAD)
    local = (places - view.position_enu_m) @ view.rotation_enu_from_optical
    assert (local[:, 2] > 0).all()
    half = math.tan(FOV_RAD / 2)
    seen = np.abs(local[:, :2] / local[:, 2:]) / (half * 4 / 3, half)
    assert seen.max() < 1.0
    if local[:, 2].min() > 1.1:  # else the eye keeps clear of what is nearest
        assert seen.max() > 0.9
