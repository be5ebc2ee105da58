"""Every criterion of a landing site by itself: what just meets it, and what just does not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from autonomy.perception.criteria import Ground, first_lack, is_safe
from autonomy.perception.needs import LandingNeeds

NEEDS = LandingNeeds(footprint_radius_m=0.25, body_radius_m=0.4)
EVEN = Ground(
    slope_rad=np.array(0.0),
    slope_sigma_rad=np.array(0.0),
    roughness_m=np.array(0.0),
    sigma_m=np.array(0.0),
    rise_m=np.array(0.0),
)


def test_even_ground_is_safe():
    assert is_safe(EVEN, NEEDS)
    assert first_lack(EVEN, NEEDS) is None


@pytest.mark.parametrize(
    ("field", "limit", "words"),
    [
        ("slope_rad", NEEDS.max_slope_rad, "slope"),
        ("slope_sigma_rad", NEEDS.max_slope_rad / 2, "more"),
        ("sigma_m", NEEDS.max_sigma_m, "heights known to"),
        ("roughness_m", NEEDS.max_roughness_m, "height range"),
        ("rise_m", NEEDS.max_rise_m, "rises"),
    ],
)
def test_ground_is_refused_beyond_each_limit(field, limit, words):
    def at(value):
        return replace(EVEN, **{field: np.array(value)})

    assert is_safe(at(0.99 * limit), NEEDS)
    assert not is_safe(at(1.01 * limit), NEEDS)
    assert words in first_lack(at(1.01 * limit), NEEDS)
    assert not is_safe(at(math.nan), NEEDS)
