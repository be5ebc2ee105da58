from __future__ import annotations

from dataclasses import replace

import pytest

from aeroscene.learning.tokens.kinds import DOMAINS, Vocabulary, count_kinds
from aeroscene.learning.tokens.placed import site_yaw
from aeroscene.learning.tokens.training_set import TrainingSet
from aeroscene.scene import OrientedBox, Scene
from aeroscene.scene.box import quat_from_yaw


def test_vocabulary_survives_its_text(known: TrainingSet) -> None:
    again = Vocabulary.from_json(known.vocabulary.to_json())
    assert again.kinds == known.vocabulary.kinds
    assert again.digest == known.vocabulary.digest


def test_vocabulary_does_not_depend_on_the_order_of_scenes(scenes: list[Scene]) -> None:
    assert count_kinds(scenes).digest == count_kinds(scenes[::-1]).digest
    assert count_kinds(scenes).digest != count_kinds(scenes[1:]).digest


def test_sites_come_first_and_are_no_category(known: TrainingSet) -> None:
    kinds = known.vocabulary.kinds
    assert [kind.is_site for kind in kinds[:4]] == [True, True, True, False]
    assert known.vocabulary.category_id[: len(DOMAINS)].tolist() == [0, 0, 0]
    assert known.vocabulary.category_id[len(DOMAINS) :].min() > 0


def test_every_object_has_a_kind_and_its_looks_are_counted(
    known: TrainingSet, scenes: list[Scene]
) -> None:
    n_objects = sum(len(scene.objects) for scene in scenes)
    counted = sum(look.count for looks in known.vocabulary.looks for look in looks)
    assert counted == n_objects


def test_strange_object_has_no_kind(known: TrainingSet, scenes: list[Scene]) -> None:
    obj = scenes[0].objects[0]
    strange = replace(obj, attributes={**obj.attributes, "form": "of no scene"})
    with pytest.raises(KeyError, match="of no scene"):
        known.vocabulary.kind_of(strange, None)


def test_attachment_says_where_the_underside_is(known: TrainingSet, scenes: list[Scene]) -> None:
    for scene in scenes:
        yaw = site_yaw(scene)
        for obj in scene.objects:
            parent = scene.object_by_id.get(obj.parent_id if obj.parent_id is not None else -1)
            kind = known.vocabulary.kinds[known.vocabulary.kind_of(obj, parent, yaw)]
            if kind.attachment == "top":
                assert parent is not None
                top = parent.bbox.p[2] + parent.bbox.s[2] / 2
                assert obj.bbox.p[2] - obj.bbox.s[2] / 2 == pytest.approx(top, abs=0.011)


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
