"""Every kind of room under its name."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from aeroscene.corpus.curation.rooms import fair, home, public, storage, work
from aeroscene.corpus.curation.rooms.interior import Interior

FURNISHINGS: dict[str, Callable[[Interior], Iterator[None]]] = {
    "office": work.furnish_office,
    "open_office": work.furnish_open_office,
    "meeting": work.furnish_meeting,
    "workshop": work.furnish_workshop,
    "classroom": work.furnish_classroom,
    "library": work.furnish_library,
    "living": home.furnish_living,
    "bedroom": home.furnish_bedroom,
    "kitchen": home.furnish_kitchen,
    "dining": home.furnish_dining,
    "cafe": public.furnish_cafe,
    "lobby": public.furnish_lobby,
    "lounge": public.furnish_lounge,
    "corridor": public.furnish_corridor,
    "garden": public.furnish_garden,
    "gym": public.furnish_gym,
    "changing": public.furnish_changing,
    "court": public.furnish_court,
    "stand": public.furnish_stand,
    "concourse": public.furnish_concourse,
    "store": storage.furnish_store,
    "racks": storage.furnish_racks,
    "goods": storage.furnish_goods,
    "storage": storage.furnish_storage,
    "aisles": storage.furnish_aisles,
    "produce": storage.furnish_produce,
    "checkout": storage.furnish_checkout,
    "booths": fair.furnish_booths,
}
"""What each kind of room contains: steps that each leave the room whole, most telling first."""

__all__ = ["FURNISHINGS", "Interior"]
