"""Mirror images of scenes are scenes of the same kind, and other ones."""

import numpy as np
import pytest

from aeroscene.learning.program import encode
from aeroscene.learning.symmetry import draw_symmetry, mirrored
from aeroscene.metrics.places.seating import averted_chairs
from aeroscene.metrics.places.top_view import TopView
from aeroscene.metrics.places.walls import loose_wall_ends
from tests.aeroscene.conftest import cached_scene

INDOOR = 5


@pytest.mark.parametrize(("domain", "n_seen"), [("indoor", 8), ("outdoor", 4), ("mixed", 4)])
def test_traffic_keeps_to_the_right_whatever_symmetry_is_drawn(domain, n_seen):
    rng = np.random.default_rng(0)
    seen = {draw_symmetry(domain, rng) for _ in range(200)}
    assert len(seen) == n_seen
    assert any(is_mirrored for _, is_mirrored in seen) == (domain == "indoor")


def test_a_mirror_image_is_as_good_a_place_and_another_one():
    scene = cached_scene(INDOOR)
    assert scene.domain == "indoor"
    image = mirrored(scene)
    assert mirrored(image).objects == scene.objects
    assert image.objects != scene.objects
    for check in (averted_chairs, loose_wall_ends):
        found, own = check(TopView(image)), check(TopView(scene))
        assert len(found) == len(own) > 0
        assert found.mean() == pytest.approx(own.mean())
    kinds, own_kinds = encode(image).program.kinds, encode(scene).program.kinds
    assert len(kinds) == len(own_kinds)
    assert kinds != own_kinds
