from __future__ import annotations

from dataclasses import replace

import pytest

from aeroscene.learning.tokens.kinds import DOMAINS, Vocabulary, count_kinds
from aeroscene.learning.tokens.placed import SITE, site_yaw
from aeroscene.scene import OrientedBox, Scene
from aeroscene.scene.box import quat_from_yaw


def test_vocabulary_survives_its_text(scenes: list[Scene]) -> None:
    again = Vocabulary.from_json(count_kinds(scenes).to_json())
    assert again.kinds == count_kinds(scenes).kinds
    assert again.to_json() == count_kinds(scenes).to_json()


def test_vocabulary_does_not_depend_on_the_order_of_scenes(scenes: list[Scene]) -> None:
    assert count_kinds(scenes).to_json() == count_kinds(scenes[::-1]).to_json()
    assert count_kinds(scenes).to_json() != count_kinds(scenes[1:]).to_json()


def test_sites_come_first_and_are_no_category(scenes: list[Scene]) -> None:
    kinds = count_kinds(scenes).kinds
    assert [kind.category == SITE for kind in kinds[:4]] == [True, True, True, False]
    assert count_kinds(scenes).category_id[: len(DOMAINS)].tolist() == [0, 0, 0]
    assert count_kinds(scenes).category_id[len(DOMAINS) :].min() > 0


def test_every_object_has_a_kind_and_its_looks_are_counted(scenes: list[Scene]) -> None:
    n_objects = sum(len(scene.objects) for scene in scenes)
    counted = sum(look.count for looks in count_kinds(scenes).looks for look in looks)
    assert counted == n_objects


@pytest.mark.parametrize("yaw", [0.0, 0.3, -0.7])
def test_site_is_turned_as_most_of_its_roots_are(scene_42: Scene, yaw: float) -> None:
    first = site_yaw(scene_42)
    turned = replace(
        scene_42,
        interaction_areas=(),
        objects=tuple(
            replace(
                obj,
                bbox=OrientedBox(obj.bbox.p, quat_from_yaw(obj.bbox.yaw_rad + yaw), obj.bbox.s),
            )
            for obj in scene_42.objects
        ),
    )
    quarter = 3.141592653589793 / 2
    difference = (site_yaw(turned) - first - yaw) % quarter
    assert min(difference, quarter - difference) < 1e-3
