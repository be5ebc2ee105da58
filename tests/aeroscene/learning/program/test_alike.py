"""What is as large, as wide or as straight as something else is so whatever the numbers are."""

from collections import Counter
from dataclasses import replace
from functools import cache

import msgspec
import numpy as np
import pytest

from aeroscene.corpus.curation import curate_layout
from aeroscene.learning.generation.denoising import frame_values
from aeroscene.learning.program import DecodingCfg, decode, encode
from aeroscene.learning.program.decoding.draft.trees import TreeReader
from aeroscene.learning.program.kinds import AS_LAST_AXES, KINDS
from aeroscene.learning.program.references import measure_references, with_references
from aeroscene.scene.catalogue import STAIRS

AS_DRAWN = DecodingCfg(mends=False, makes_room=False)
SEEDS = (1, 3, 7, 14)


@cache
def encoded(seed):
    return encode(curate_layout(seed))


def blurred(seed):
    """A scene's program with all its numbers 10% off, heights and headings too."""
    program = with_references(encoded(seed), measure_references([encoded(seed)]))
    noise = np.random.default_rng(seed).normal(1.0, 0.1, program.channels.shape)
    return program.with_channels(program.channels * noise)


def pairs_as_last(program, decoded):
    """Boxes of units that are as large as the last one, that one's box, and which axes count."""
    last = {}
    ids = [(made[0], place) for place, made in enumerate(decoded.object_ids) if made]
    for first, place in sorted(ids):
        kind = program.kinds[place]
        box = decoded.scene.object_by_id[first].bbox
        if kind.node == "unit" and not kind.is_group:
            if kind.what in last and kind.as_last:
                axes = AS_LAST_AXES[kind.as_last]
                # Stairs are as high as the level that they lead to.
                axes = axes[:2] if kind.category == "stairs" else axes
                yield box, last[kind.what], axes
            last[kind.what] = box
        elif kind.node == "unit":
            last.pop(kind.what, None)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_was_as_large_as_the_last_one_is_so_by_other_numbers(seed):
    program = blurred(seed)
    decoded = decode(program, cfg=AS_DRAWN)
    found = list(pairs_as_last(program, decoded))
    assert len(found) > 5
    for box, last, axes in found:
        assert [box.s[i] for i in axes] == pytest.approx([last.s[i] for i in axes], abs=1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_first_of_its_kind_is_as_large_as_the_next_with_numbers(seed):
    """A drawn program may say of the first table built that it is as large as the last one."""
    program = with_references(encoded(seed), measure_references([encoded(seed)]))
    units = [i for i, kind in enumerate(program.kinds) if kind.node == "unit"]
    own = [i for i in units if not program.kinds[i].as_last and not program.kinds[i].is_group]
    # Floors are as large as their rooms ask for, and roofs as large as their buildings.
    fitted = {"floor", "roof"}
    n_of = Counter(program.kinds[i].what for i in own if program.kinds[i].category not in fitted)
    kinds, channels = list(program.kinds), program.channels.copy()
    swapped = {}
    for i in own:
        what = kinds[i].what
        if n_of[what] > 1 and what not in swapped and kinds[i].category not in STAIRS:
            swapped[what] = i
            kinds[i] = msgspec.structs.replace(kinds[i], as_last="size")
            channels[i, 5:8] = np.nan
    assert swapped
    decoded = decode(replace(program, kinds=tuple(kinds), channels=channels), cfg=AS_DRAWN)
    for what, place in swapped.items():
        first = decoded.scene.object_by_id[decoded.object_ids[place][0]].bbox.s
        # The members of a group may differ from what the group says.
        others = [i for i in units if kinds[i].what == what and i != place]
        said = [np.exp(program.channels[i, 5:8]) for i in others]
        built = [decoded.scene.object_by_id[decoded.object_ids[i][0]].bbox.s for i in others]
        assert any(first == pytest.approx(size, abs=1e-3) for size in (*said, *built))


def test_what_is_as_the_last_one_has_no_numbers_of_its_own():
    program = with_references(encoded(1), measure_references([encoded(1)]))
    said = {kind.as_last for kind in program.kinds if kind.node == "unit"}
    assert said == {"", "size", "plan", "height"}
    for kind, row in zip(program.kinds, program.channels, strict=True):
        is_missing = np.isnan(row[5:8])
        assert kind.node != "unit" or np.flatnonzero(is_missing).tolist() == sorted(
            AS_LAST_AXES[kind.as_last]
        )


def test_only_what_is_turned_has_a_heading_of_its_own():
    is_turned = []
    for seed in SEEDS:
        program = encoded(seed).program
        for kind, row in zip(program.kinds, program.channels, strict=True):
            if kind.node == "unit":
                assert np.isnan(row[2:4]).all() == (not kind.is_turned)
                is_turned.append(kind.is_turned)
    assert 0.0 < np.mean(is_turned) < 0.25


def sites(count):
    found = (encoded(seed).program for seed in range(60))
    with_site = ((p, i) for p in found for i, k in enumerate(p.kinds) if k.node == "site")
    return [next(with_site) for _ in range(count)]


def test_a_site_along_the_axes_lies_so_by_other_numbers_and_a_turned_one_as_it_did():
    seen = set()
    for program, place in sites(30):
        kind = program.kinds[place]
        head, _ = TreeReader(program, program.children()).head(place)
        quarters = head.record.values[2] / (np.pi / 2)
        assert (abs(quarters - round(quarters)) > 1e-3) == kind.is_turned
        if not kind.is_turned:
            assert round(quarters) % 4 == kind.turn
            seen.add(kind.turn % 2)
    assert seen == {0, 1}


@pytest.mark.parametrize("node", ["site", "unit"])
def test_outline_of_what_lies_across_the_axes_has_its_sides_the_other_way_round(node):
    along, across = (KINDS[node](node, turn=turn) for turn in (2, 3))
    assert np.exp(frame_values((70.0, 60.0), along)[4:]) == pytest.approx([70.0, 60.0])
    assert np.exp(frame_values((70.0, 60.0), across)[4:]) == pytest.approx([60.0, 70.0])


def even_parts(program):
    children = program.children()
    for place, kind in enumerate(program.kinds):
        if kind.node == "slice" and any(program.kinds[i].is_even for i in children[place]):
            yield place, children[place]


def test_parts_that_were_equal_are_so_by_other_shares():
    n_seen = 0
    for seed in range(1, 40):
        program = encoded(seed).program
        blurry = program.with_channels(
            program.channels * np.random.default_rng(seed).normal(1, 0.2, program.channels.shape)
        )
        grower = TreeReader(blurry, blurry.children())
        for _, parts in even_parts(program):
            logits = [grower._logit(i) for i in parts]
            for number, place in enumerate(parts):
                kind = program.kinds[place]
                if not kind.is_even:
                    continue
                before = [
                    logit
                    for logit, other in zip(logits[:number], parts, strict=False)
                    if program.kinds[other].category == kind.category
                    and program.kinds[other].node == kind.node
                    and not program.kinds[other].strip
                ]
                assert logits[number] == before[-1]
                n_seen += 1
    assert n_seen > 10


def test_equal_things_come_back_unequal_where_nothing_says_that_they_are_equal():
    """The check falls where the kinds do not say it: sizes blurred by 10% are all different."""
    program = blurred(1)
    kinds = tuple(
        msgspec.structs.replace(kind, as_last="") if kind.node == "unit" else kind
        for kind in program.kinds
    )
    channels = np.where(np.isnan(program.channels), 0.3, program.channels)
    decoded = decode(replace(program, kinds=kinds, channels=channels), cfg=AS_DRAWN)
    pairs = list(pairs_as_last(program, decoded))
    differ = [max(abs(box.s[i] - last.s[i]) for i in axes) > 0.01 for box, last, axes in pairs]
    assert len(pairs) > 5
    assert np.mean(differ) > 0.3
