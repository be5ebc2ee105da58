from dataclasses import replace

import numpy as np
import pytest

from aeroscene.metrics.displacement import UnlikeScenesError, displacement
from tests.aeroscene.metrics.scenes import box, moved, scene_of

BEFORE = scene_of(*(("tree", box((5.0 * i, 0, 3), (2, 2, 6))) for i in range(4)))


def test_nothing_happens_to_a_scene_that_stays():
    none = displacement([BEFORE], [BEFORE])
    assert (none.median_m, none.p95_m, none.moved_share, none.dropped_share) == (0, 0, 0, 0)


def test_moves_are_distances_of_centres_and_drops_do_not_count():
    after = moved(BEFORE, [[3, 4, 0], [0, 0, 0], [0, 0, 1], [9, 9, 9]])
    after = replace(after, objects=after.objects[:3])
    found = displacement([BEFORE], [after])
    assert found.median_m == 1.0
    assert found.mean_m == pytest.approx(2.0)
    assert (found.moved_share, found.dropped_share) == (pytest.approx(2 / 3), 1 / 4)


def test_trimmed_objects_are_counted():
    first, *others = BEFORE.objects
    slim = replace(first, bbox=replace(first.bbox, s=(1.9, 2.0, 6.0)))
    after = replace(BEFORE, objects=(slim, *others))
    assert displacement([BEFORE, BEFORE], [BEFORE, after]).resized_share == 1 / 8


def test_a_scene_that_lost_everything_has_no_displacement():
    gone = displacement([BEFORE], [replace(BEFORE, objects=())])
    assert (gone.median_m, gone.dropped_share) == (0.0, 1.0)


def test_another_scene_is_refused():
    other = scene_of(("bush", box((0, 0, 1), (1, 1, 1))))
    with pytest.raises(UnlikeScenesError, match="object 10 is a bush"):
        displacement([BEFORE], [other])
    assert np.isfinite(displacement([other], [other]).mean_m)
