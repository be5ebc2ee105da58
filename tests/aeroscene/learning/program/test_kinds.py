"""Kinds of tokens, each node with its own fields, and the JSON that they have in vocabularies."""

import msgspec
import pytest

from aeroscene.learning.generation.loading import SHIPPED
from aeroscene.learning.program.decoding.draft.trees import record_of
from aeroscene.learning.program.encoding.partitions import _kind
from aeroscene.learning.program.kinds import KINDS, Kind, StoreyKind, UnitKind
from aeroscene.learning.training.checkpoint import read_checkpoint
from aeroscene.learning.writer.language import Language
from aeroscene.partition import Record

LAWN = '["lawn","outdoor",[]]'
RECORDS = [
    (Record("site"), {"node": "site"}),
    (Record("storey", is_inset=True), {"node": "storey", "arity": 1}),
    (
        Record("leaf", kind=LAWN, merge=2, quarter=3, strip=1),
        {"node": "leaf", "category": "lawn", "domain": "outdoor"}
        | {"merge": 2, "quarter": 3, "strip": 1},
    ),
    (Record("slice", "x", 3), {"node": "slice", "axis": "x", "arity": 3}),
    (Record("cross", "", 2, 3, strip=4), {"node": "cross", "arity": 2, "rows": 3, "strip": 4}),
    (Record("grid", "", 4, 5), {"node": "grid", "arity": 4, "rows": 5}),
    (Record("bend", "", 6, 2), {"node": "bend", "arity": 6, "rows": 2}),
    (Record("overlay", "", 7), {"node": "overlay", "arity": 7}),
    (Record("pinwheel", is_mirrored=True), {"node": "pinwheel", "arity": 1}),
    (Record("item", is_placed=True), {"node": "item", "arity": 1}),
    (Record("bank"), {"node": "bank"}),
    (Record("part", strip=2), {"node": "part", "strip": 2}),
    (Record("segment", kind="door"), {"node": "segment", "category": "door"}),
]


@pytest.mark.parametrize(("record", "plain"), RECORDS, ids=lambda value: getattr(value, "node", ""))
def test_kind_of_a_record_is_the_record_in_json_and_back(record, plain):
    kind = _kind(record)
    assert msgspec.json.decode(msgspec.json.encode(kind)) == plain
    assert msgspec.convert(plain, KINDS[record.node]) == kind
    assert repr(record_of(kind)) == repr(record)


def test_flags_have_names_of_their_own_and_the_keys_of_counts_in_json():
    kind = StoreyKind("storey", is_inset=1, is_first=1)
    assert msgspec.json.encode(kind) == b'{"node":"storey","arity":1,"rows":1}'


@pytest.mark.parametrize("kind", [Kind("scene"), StoreyKind("storey"), UnitKind("unit")])
def test_what_is_asked_of_any_kind_is_empty_where_it_says_nothing(kind):
    assert not any((kind.strip, kind.turn, kind.relation, kind.is_turned))
    assert not any((kind.is_even, kind.is_root, kind.is_group))


def test_the_vocabulary_of_the_shipped_model_comes_back_to_the_byte():
    checkpoint = read_checkpoint(SHIPPED["default"])
    assert isinstance(checkpoint.known, Language)
    assert checkpoint.known.to_json() == checkpoint.facts.vocabulary
