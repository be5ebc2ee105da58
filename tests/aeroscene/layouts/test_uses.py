from __future__ import annotations

import pytest

from aeroscene.corpus.curation.interiors import FURNISHINGS
from aeroscene.layouts.uses import USES, room_use


def test_every_use_is_one_that_the_grammar_furnishes():
    assert set(USES) <= set(FURNISHINGS)


@pytest.mark.parametrize(
    ("name", "use"),
    [
        ("MasterBedroom", "bedroom"),
        ("LivingDiningRoom", "dining"),
        ("living room", "living"),
        ("Kitchen", "kitchen"),
        ("open_office", "open_office"),
        ("store room", "storage"),
        ("Study 2", "office"),
        ("room", None),
        ("", None),
        ("ESC \x1b]0;", None),
    ],
)
def test_names_of_rooms_say_their_use(name, use):
    assert room_use(name) == use
