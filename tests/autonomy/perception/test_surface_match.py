"""An estimate that drifts stays tied to where the flight began, by what was seen on the way."""

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from autonomy.perception.map_anchor import MapAnchor
from autonomy.perception.map_anchor_cfg import SEEN_SO_FAR
from autonomy.perception.surface_match import SurfaceMatcher
from tests.autonomy.depth_scene import box, look_down, quat_of

LOW, HIGH = (-10.0, -12.0, 0.0), (30.0, 12.0, 10.0)
PITCH = math.radians(15.0)
ROWS = [
    ((4.0 + 4.5 * n, side * (2.6 + 0.5 * (n % 3)), 1.0), (1.4, 1.2, 2.0 + n % 2))
    for n in range(6)
    for side in (-1, 1)
]
YARD = [box(*each) for each in ROWS]
POOR = replace(SEEN_SO_FAR, walk_of_sigma=0.05).for_accuracy(1.8, 2.7)
"""As if the velocity were not followed: only images tell of the drift."""


def fly(images, cfg=POOR):
    """Flies 8 m ahead in 8 s past blocks; the estimate errs by `error(t)`. Returns what is left."""
    anchor = MapAnchor(SurfaceMatcher(LOW, HIGH), cfg)
    left = []
    for time_s, true, image in images:
        if not left:
            anchor.stand_at(time_s, image.position_enu_m, true)
        anchor.update(time_s, image)
        left.append(np.add(image.position_enu_m, anchor.fix.offset_enu_m) - true)
    return anchor, np.array(left)


def course(error, solids=YARD, pitch=PITCH):
    for n in range(41):
        time_s = 0.2 * n
        true = (time_s, 0.3 * math.sin(time_s), 2.5)
        quat = quat_of((0.0, 0.0, 0.15 * math.sin(0.7 * time_s)))
        believed = (tuple(np.add(true, error(time_s))), quat)
        yield time_s, true, look_down(true, quat, boxes=solids, believed=believed, pitch_down=pitch)


def wander(time_s):
    return (0.9 + 0.12 * time_s, -0.4 - 0.15 * time_s, 3.0 + 0.5 * math.sin(0.5 * time_s))


def test_a_wandering_estimate_stays_tied_to_what_was_seen():
    anchor, left = fly(course(wander))
    assert np.abs(left).max() < 0.1
    assert anchor.sigma_m < 0.1


def test_over_a_bare_floor_the_height_is_kept_and_nothing_else_is_claimed():
    anchor, left = fly(course(wander, solids=()))
    assert np.abs(left[:, 2]).max() < 0.08
    assert anchor.sigma_m > 0.2


def test_what_was_not_seen_before_is_learned_and_corrects_nothing():
    anchor = MapAnchor(SurfaceMatcher(LOW, HIGH), POOR)
    first, second = (image for _, _, image in islice(course(wander), 2))
    fix = anchor.update(0.0, first)
    assert not fix.accepted
    assert "surfaces are known" in fix.reason
    assert fix.offset_enu_m == (0.0, 0.0, 0.0)
    assert anchor.update(0.2, second).accepted


def test_another_place_altogether_is_refused_and_not_learned():
    images = [image for _, _, image in islice(course(wander), 7)]
    anchor = MapAnchor(SurfaceMatcher(LOW, HIGH), POOR)
    for n in range(5):
        anchor.update(0.2 * n, images[n])
    before = anchor.fix.offset_enu_m
    elsewhere = [box((3.0, 0.0, 2.0), (0.4, 9.0, 5.0))]
    other = look_down(images[5].position_enu_m, boxes=elsewhere, pitch_down=PITCH, ground=2.0)
    assert not anchor.update(1.0, other).accepted
    assert anchor.fix.offset_enu_m == pytest.approx(before)
    assert anchor.update(1.2, images[6]).accepted


def test_a_sure_estimate_is_relied_on_and_its_images_are_learned():
    anchor = MapAnchor(SurfaceMatcher(LOW, HIGH), SEEN_SO_FAR.for_accuracy(0.05, 0.08))
    images = list(islice(course(lambda _: (0.4, 0.2, -0.3)), 11))
    anchor.stand_at(0.0, images[0][2].position_enu_m, images[0][1], 0.01)
    offset = anchor.offset_enu_m
    for time_s, _, image in images[:10]:
        anchor.rely(time_s, image)
    assert anchor.sigma_m < 0.1
    fix = anchor.update(2.0, images[10][2])
    assert fix.accepted
    assert fix.offset_enu_m == pytest.approx(offset, abs=0.05)
