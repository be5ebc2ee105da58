from __future__ import annotations

from collections import Counter

import msgspec
import numpy as np
import pytest

from aeroscene.learning.paper.looks import Looks
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import CATALOGUE


def test_looks_survive_their_text_and_the_order_of_scenes(scenes: list[Scene]) -> None:
    looks = Looks.from_scenes(scenes)
    assert Looks.from_json(looks.to_json()) == looks
    assert Looks.from_scenes(scenes[::-1]).to_json() == looks.to_json()
    assert Looks.from_scenes(scenes[1:]).to_json() != looks.to_json()
    with pytest.raises(msgspec.DecodeError):
        Looks.from_json('{"Chair": 3}')
    with pytest.raises(ValueError, match="no category has a look"):
        Looks.from_json('{"Chair": []}')


def test_every_object_without_an_opening_is_counted(scenes: list[Scene]) -> None:
    plain = Counter(
        obj.category
        for scene in scenes
        for obj in scene.objects
        if not {"door_m", "window_m"} & set(obj.attributes)
    )
    found = Looks.from_scenes(scenes).by_category
    assert {name: sum(look.count for look in looks) for name, looks in found.items()} == plain
    assert 0 < plain.total() < sum(len(scene.objects) for scene in scenes)


def test_looks_are_drawn_as_often_as_they_were_found(scenes: list[Scene]) -> None:
    looks = Looks.from_scenes(scenes)
    number = max(CATALOGUE, key=lambda c: len(looks.by_category.get(CATALOGUE[c].name, ())))
    known, rng = looks.by_category[CATALOGUE[number].name], np.random.default_rng(0)
    drawn = Counter(known.index(looks.draw(number, rng)) for _ in range(2000))
    share = known[0].count / sum(look.count for look in known)
    assert drawn[0] / 2000 == pytest.approx(share, abs=0.05)
    assert len(drawn) > 1
