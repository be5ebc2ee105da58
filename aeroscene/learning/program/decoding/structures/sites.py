"""The covers of a site from their tokens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.learning.program.decoding.structures.buildings import DecodedBuilding
from aeroscene.learning.program.decoding.structures.strips import settled
from aeroscene.learning.program.decoding.structures.yards import laid_about
from aeroscene.learning.program.kinds import Word
from aeroscene.learning.program.nesting import cells
from aeroscene.partition import SitePartition, build_site, from_sequence
from aeroscene.partition.tree import VOID
from aeroscene.relations.plane import footprint
from aeroscene.scene import OrientedBox, SceneObject

_Cover = tuple[int, Word, OrientedBox]
"""Place of a cover's token, its word, and its box."""
# Least side of a cover, and greatest gap between a cover and the one that bears it.
_LEAST_COVER_M = 0.05
_ON_M = 1e-6


def add_site(draft: Draft, place: int, house: DecodedBuilding | None = None) -> None:
    """Add the covers of a site to the draft, around the house that stands on it.

    Args:
        draft: Changed.
        place: Place of the site's token.
        house: House of rooms and walls on the site, if there is one.
    """
    grown, widths = draft.trees.head(place)
    tokens = cells(grown)
    plain = from_sequence([*widths, *grown.flat()])
    assert isinstance(plain, SitePartition)
    frame = plain.frame
    tree = settled(plain.tree, frame.length_m, frame.width_m, _LEAST_COVER_M)
    drawn = [
        (token, Word.read(cover.kind), cover.box)
        for cover in build_site(replace(plain, tree=tree))
        if cover.kind != VOID and (token := tokens[cover.leaf][0]) is not None
    ]
    for token, word, box in drawn if house is None else _about(draft, house, drawn):
        # Further pieces of one cover are children of the piece before.
        parent = draft.made[token][-1] if draft.made[token] else None
        if parent is None and not draft.program.kinds[token].is_root:
            parent = _under(draft.objects, box, word)
        attributes = dict(word.attributes)
        draft.add(token, word.category, word.domain, attributes, box, parent=parent, bearer=None)


def _about(draft: Draft, house: DecodedBuilding, drawn: list[_Cover]) -> list[_Cover]:
    """Lay the same covers anew around a house, if they are one yard that bears nothing."""
    words = {word for _, word, _ in drawn}
    if len(words) != 1 or any(draft.children[token] for token, _, _ in drawn):
        return drawn
    laid = laid_about(house, [box for _, _, box in drawn])
    return drawn if laid is None else [(*drawn[number][:2], box) for box, number in laid]


def _under(objects: Sequence[SceneObject], box: OrientedBox, word: Word) -> int | None:
    """Return the cover that bears another, or the last one of its category before it."""
    base_m = box.p[2] - box.s[2] / 2
    found: int | None = None
    for obj in objects:
        top_m = obj.bbox.p[2] + obj.bbox.s[2] / 2
        u_m, v_m, _ = footprint(obj.bbox).place.local(footprint(box).place)
        is_over = abs(u_m) <= obj.bbox.s[0] / 2 and abs(v_m) <= obj.bbox.s[1] / 2
        if abs(top_m - base_m) < _ON_M and is_over:
            return obj.id
        found = obj.id if obj.category == word.category else found
    return found
