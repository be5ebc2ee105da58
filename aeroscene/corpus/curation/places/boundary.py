"""Fences round a parcel, with a gate to the street."""

from __future__ import annotations

from collections.abc import Iterator

from aeroscene.corpus.curation.places.ground import Ground

_INSET_M = 0.3


def enclose(
    ground: Ground, form: str, height: float, gate: tuple[float, float] | None = None
) -> Iterator[None]:
    """Place fences along the back, the two sides and the front.

    Args:
        ground: Parcel.
        form: Form of the fences.
        height: Height of the fences, m.
        gate: Ends of the gate in the front, u; None leaves the whole front open.
    """
    u1, v0, v1 = ground.parcel.width / 2 - _INSET_M, _INSET_M, ground.parcel.depth - _INSET_M
    # Side fences end before the back one, so that corners do not overlap.
    corner = 0.2
    ground.fence_line((-u1, v1), (u1, v1), form, height)
    yield
    for side in (-1, 1):
        ground.fence_line((side * u1, v0 + corner), (side * u1, v1 - corner), form, height)
        yield
    if gate is None:
        return
    for start, end in ((-u1, gate[0]), (gate[1], u1)):
        if end - start > 1.2:
            ground.fence_line((start, v0), (end, v0), form, height)
    yield
