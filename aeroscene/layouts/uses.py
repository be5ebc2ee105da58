"""Use of a room by its name: our word for the names of other sources."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import pairwise

USES: Mapping[str, tuple[str, ...]] = {
    "bedroom": ("bedroom", "bed", "sleeping", "nursery", "kids", "children", "guest"),
    "kitchen": ("kitchen", "kitchenette", "pantry"),
    "bathroom": ("bath", "shower", "ensuite"),
    "washroom": ("restroom", "toilet", "toilets", "lavatory", "wc", "powder"),
    "dining": ("dining",),
    "living": ("living", "livingroom", "family", "sitting"),
    "office": ("office", "study", "work", "desk"),
    "open_office": ("open office", "coworking"),
    "meeting": ("meeting", "conference", "board", "seminar"),
    "classroom": ("class", "classroom", "lecture", "teaching", "auditorium"),
    "corridor": ("corridor", "hallway", "hall", "passage", "aisle", "landing"),
    "lobby": ("lobby", "reception", "foyer", "entrance", "waiting"),
    "lounge": ("lounge", "break", "common"),
    "library": ("library", "reading"),
    "storage": ("storage", "store room", "utility", "closet", "cellar", "garage", "technical"),
    "workshop": ("workshop", "laboratory", "lab", "maker"),
    "gym": ("gym", "fitness", "sports"),
    "cafe": ("cafe", "canteen", "restaurant", "cafeteria", "bar"),
    "store": ("shop", "store", "retail"),
    "changing": ("changing", "locker"),
}
"""Words in names of rooms, under our use for them."""


def room_use(name: str) -> str | None:
    """Our use for the name of a room such as `MasterBedroom`; None if no word is known."""
    # Between a lower and an upper case letter begins a new word.
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    words = re.findall("[a-z]+", spaced.lower())
    pairs = [" ".join(pair) for pair in pairwise(words)]
    # Pairs of words first, then the last word: an open office is no office.
    for word in (*pairs, *words[::-1]):
        for use, known in USES.items():
            if word in known or word == use:
                return use
    return None
