from dataclasses import replace

import numpy as np
import pytest

from aeroscene.relations import Kind, scene_relations
from aeroscene.relations.records import to_records, to_units
from aeroscene.relations.relation import SYMBOLS
from tests.aeroscene.relations.rooms import dining


def read(scene):
    return scene_relations(scene), [obj for obj in scene.objects if obj.is_coarse]


def test_records_of_a_corpus_scene_give_its_units_back(scene):
    units, coarse = read(scene)
    records = to_records(units, coarse)
    ids = iter([member.id for unit in units for member in unit.members])
    assert to_units(records, coarse, ids) == units


def test_a_record_says_what_is_noise_and_what_is_to_be_drawn():
    scene = dining()
    table, chairs = to_records(*read(scene))
    assert not table.is_pinned[:2].any()
    assert np.abs(table.values[:2]).max() > 0.4
    assert chairs.is_pinned.tolist() == [True, True, True, False, False]
    assert np.abs(chairs.values[:3]).max() < 0.1
    assert chairs.member_values.shape == (4, 4)
    assert dict(zip(SYMBOLS, chairs.fields.tolist(), strict=True))["kind"] == Kind.SEAT


def test_a_host_that_does_not_stand_is_refused():
    units, coarse = read(dining())
    *first, chairs = to_records(units, coarse)
    fields = chairs.fields.copy()
    fields[list(SYMBOLS).index("host")] = 5
    with pytest.raises(IndexError):
        to_units([*first, replace(chairs, fields=fields)], coarse)
