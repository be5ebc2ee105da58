"""What may be asked for, and what is drawn of what is not."""

from __future__ import annotations

import numpy as np
import pytest

from aeroscene.learning.generation import AreaCounts, Request, RequestError
from aeroscene.learning.wishes import Wish
from tests.aeroscene.conftest import cached_scene


def drawn(request: Request, seed: int = 0):
    return request.drawn(np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"seed": -1}, r"seed -1 is out of range; valid: 0 to"),
        ({"seed": 0, "n_objects": 3}, "objects 3 is out of range; valid: 20 to 250"),
        ({"seed": 0, "n_areas": 0}, "areas 0 is out of range; valid: 1 to 200"),
        ({"seed": 0, "density": 0.1}, r"density 0\.1 is out of range; valid: 0\.2 to 2"),
        ({"seed": 0, "clutter": 0.5}, r"clutter 0\.5 is out of range; valid: 1 to 10"),
        ({"seed": 0, "min_passage_m": 9.0}, r"min-passage 9\.0 is out of range; valid: 0\.5 to 3"),
        ({"seed": 0, "density": 1.5, "n_objects": 90}, "density is 1.5 beside objects 90"),
        ({"seed": 0, "outline_m": (60.0, 900.0)}, r"outline 900\.0 is out of range; valid: 15"),
    ],
)
def test_wish_out_of_range_says_what_is_valid(wish: dict, message: str) -> None:
    with pytest.raises(RequestError, match=message):
        Request(**wish)


def test_outline_and_completion_exclude_each_other() -> None:
    with pytest.raises(RequestError, match="the scene has an outline of its own"):
        Request(seed=0, outline_m=(60.0, 60.0), complete=cached_scene(42))


def test_theme_and_completion_exclude_each_other() -> None:
    with pytest.raises(RequestError, match="theme is 'park' beside a scene to complete"):
        Request(seed=0, theme="park", complete=cached_scene(42))


def test_what_is_asked_for_is_kept_and_the_rest_is_drawn() -> None:
    wish, limits = drawn(Request(seed=0, domain="indoor", n_objects=100, n_areas=30))
    assert wish.domain == "indoor"
    assert wish.n_coarse + wish.n_fine == 100
    assert limits is not None
    assert limits.small + limits.medium + limits.large == 30 == wish.n_areas
    assert limits.small > limits.medium > limits.large >= 0


def test_wishes_do_not_change_the_other_draws() -> None:
    free, _ = drawn(Request(seed=0))
    bound, _ = drawn(Request(seed=0, n_objects=100))
    assert free.domain == bound.domain
    assert free.n_areas == bound.n_areas


def test_averages_of_what_is_drawn_are_the_papers() -> None:
    wishes = [drawn(Request(seed=i), i)[0] for i in range(400)]
    assert {wish.domain for wish in wishes} == {"mixed", "outdoor", "indoor"}
    assert np.mean([wish.n_coarse for wish in wishes]) == pytest.approx(34, abs=1.5)
    assert np.mean([wish.n_fine for wish in wishes]) == pytest.approx(114, abs=5)


def test_completion_takes_domain_and_coarse_objects_from_the_scene() -> None:
    scene = cached_scene(311)
    wish, _ = drawn(Request(seed=0, complete=scene))
    assert wish.domain == "indoor"
    assert wish.n_coarse == sum(obj.is_coarse for obj in scene.objects)


def test_areas_of_named_classes_are_kept_and_the_others_drawn() -> None:
    _, free = drawn(Request(seed=0))
    wish, limits = drawn(Request(seed=0, n_areas=AreaCounts(small=9, large=0)))
    assert (limits.small, limits.large) == (9, 0)
    assert (limits.medium, limits.perching) == (free.medium, free.perching)
    assert wish.n_areas == 9 + free.medium
    with pytest.raises(RequestError, match="areas small 900 is out of range; valid: 0 to 200"):
        AreaCounts(small=900)
    with pytest.raises(RequestError, match="areas in all 0 is out of range; valid: 1 to"):
        AreaCounts(small=0, medium=0, large=0)


def test_density_multiplies_fine_objects_and_nothing_else() -> None:
    free, _ = drawn(Request(seed=3))
    dense, _ = drawn(Request(seed=3, density=1.5))
    sparse, _ = drawn(Request(seed=3, density=0.5))
    assert dense.n_fine == pytest.approx(1.5 * free.n_fine, abs=1)
    assert sparse.n_fine == pytest.approx(0.5 * free.n_fine, abs=1)
    assert (dense.domain, dense.n_coarse, dense.n_areas) == (
        free.domain,
        free.n_coarse,
        free.n_areas,
    )
    full, _ = drawn(Request(seed=3, density=2.0))
    assert full.n_coarse + full.n_fine <= 250


def test_wishes_are_named_as_their_options_and_only_where_there_are_any() -> None:
    assert Request(seed=0, domain="indoor").wishes == {}
    request = Request(
        seed=0,
        theme="park",
        n_areas=AreaCounts(large=2),
        outline_m=(70.0, 60.5),
        density=1.5,
        clutter=3.0,
        min_passage_m=1.2,
    )
    assert request.wishes == {
        "theme": "park",
        "areas_large": 2,
        "outline": "70,60.5",
        "density": 1.5,
        "clutter": 3.0,
        "min_passage": 1.2,
    }
    assert Request(seed=0, n_areas=12, n_objects=80).wishes == {"areas": 12, "objects": 80}


def test_a_scene_is_prepared_as_asked_for() -> None:
    scene, rng = cached_scene(311), np.random.default_rng(0)
    assert Request(seed=0).prepared(scene, rng) == scene
    asked = Request(seed=0, clutter=3.0, min_passage_m=2.9).prepared(scene, rng)
    assert asked.wishes == {"clutter": 3.0, "min_passage": 2.9}
    assert len(asked.objects) > len(scene.objects)
    doors = [obj.attributes["door_m"] for obj in asked.objects if "door_m" in obj.attributes]
    assert doors
    assert min(doors) >= 2.9
    limits = drawn(Request(seed=0))[1]
    assert Request(seed=0, min_passage_m=2.9).demands(limits).least_passage_m == 2.9


SEEN = (Wish("indoor", 10, 5, 7), Wish("indoor", 12, 36, 9), Wish("mixed", 40, 60, 20))


def test_open_wishes_are_those_of_the_scenes_seen_and_keep_all_areas():
    found = [Request(seed=i).drawn(np.random.default_rng(i), SEEN) for i in range(40)]
    assert {wish for wish, _ in found} == set(SEEN)
    assert all(limits is None for _, limits in found)


def test_what_is_asked_for_stands_in_the_place_of_what_was_seen():
    request = Request(seed=0, domain="mixed", n_objects=50, n_areas=10)
    wish, limits = request.drawn(np.random.default_rng(0), SEEN)
    assert (wish.domain, wish.n_coarse, wish.n_fine, wish.n_areas) == ("mixed", 20, 30, 10)
    assert limits is not None
    assert limits.small + limits.medium + limits.large == 10


def test_a_domain_that_was_never_seen_is_refused():
    with pytest.raises(RequestError, match="'outdoor'; valid: indoor, mixed; the model was"):
        Request(seed=0, domain="outdoor").drawn(np.random.default_rng(0), SEEN)


THEMES = {"mixed": {"hillside", "waterfront"}, "outdoor": {"park", "waterfront"}}


def test_an_open_domain_is_one_that_has_the_theme():
    assert set(Request(seed=0, theme="waterfront").domains(THEMES)) == {"mixed", "outdoor"}
    assert Request(seed=0, theme="waterfront", domain="mixed").domains(THEMES) == ("mixed",)
    for seen in ((), SEEN):
        for seed in range(12):
            request, rng = Request(seed=seed, theme="hillside"), np.random.default_rng(seed)
            assert request.drawn(rng, seen, THEMES)[0].domain == "mixed"


@pytest.mark.parametrize(
    ("asked", "themes", "message"),
    [
        ({"theme": "sea"}, THEMES, "^theme is 'sea'; valid: hillside, park, waterfront$"),
        (
            {"theme": "park", "domain": "mixed"},
            THEMES,
            "^theme is 'park' for domain 'mixed'; valid: hillside, waterfront$",
        ),
        (
            {"theme": "park"},
            {},
            "^theme is 'park'; valid: no theme; the model knows none, --preset",
        ),
    ],
)
def test_a_theme_that_the_model_does_not_know_there_is_refused(asked, themes, message):
    for seen in ((), SEEN):
        with pytest.raises(RequestError, match=message):
            Request(seed=0, **asked).drawn(np.random.default_rng(0), seen, themes)


def test_contents_are_those_of_scenes_of_the_theme_where_scenes_seen_say_it():
    seen = (Wish("mixed", 40, 60, 20), Wish("mixed", 30, 90, 25, "hillside"))
    requests = [Request(seed=i, theme="hillside") for i in range(12)]
    wishes = {r.drawn(np.random.default_rng(r.seed), seen, THEMES)[0] for r in requests}
    assert wishes == {seen[1]}
    silent = {r.drawn(np.random.default_rng(r.seed), seen[:1], THEMES)[0] for r in requests}
    assert silent == {Wish("mixed", 40, 60, 20, "hillside")}
    free = {Request(seed=i).drawn(np.random.default_rng(i), seen)[0] for i in range(12)}
    assert free == {seen[0], Wish("mixed", 30, 90, 25)}


def test_a_scene_is_a_wish_for_its_theme():
    scene = cached_scene(42)
    assert scene.theme
    assert Wish.from_scene(scene).theme == scene.theme


def test_a_site_gets_land_but_a_scene_that_is_given_keeps_its_ground():
    assert Request(seed=7).demands(None).land_seed == 7
    assert Request(seed=7, has_relief=False).demands(None).land_seed is None
    assert Request(seed=7, complete=cached_scene(7)).demands(None).land_seed is None
