"""Parts of a recording that a format leaves out, in words, so that nothing vanishes unnoticed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from scenarios.recording import layout
from scenarios.trial_data.reading import RecordedTrial
from scenarios.trial_data.tables import TABLES

_WORDS: Mapping[str, str] = {
    "plans": "plans",
    "frames": "camera images",
    "labels": "labels of segments",
    "scans": "lidar scans",
    "movers": "movers",
    "contacts": "contacts",
}
"""Names of tables in messages."""
_NOT_TABLES: Mapping[str, str] = {
    layout.camera(""): "images of cameras whose place was not recorded",
    "world/landing_map/": "the pilot's landing map",
    f"{layout.TRACKS}": "the pilot's tracks of movers",
    "vehicle_": "vehicles after the first",
    f"{layout.WORLD}/vehicle_": "vehicles after the first",
}
"""Parts of a recording that no format holds: beginnings of their entities, in words."""
_DERIVED = (
    "error/",
    layout.CHASE,
    layout.EXECUTED,
    layout.EARLIER_PLANS,
    layout.TOUCHED,
    layout.CONTACTS,
)
"""Parts that other tables have in another form: errors and paths follow from states, old plans from
plans, contacts from contacts. The chase camera is no part of the vehicle."""


def left_out(trial: RecordedTrial, tables: Iterable[str] = TABLES) -> list[str]:
    """Return the parts of a recording that a format does not hold, in words.

    Args:
        trial: The recording.
        tables: Tables that the format holds; all by default.
    """
    kept = set(tables)
    found = [
        _WORDS.get(name, name)
        for name, table in trial.tables.items()
        if name not in kept and len(table)
    ]
    for entity in sorted(trial.others):
        # Parts that follow from other tables are not lost.
        if not entity.startswith(_DERIVED):
            words = (said for start, said in _NOT_TABLES.items() if entity.startswith(start))
            found.append(next(words, entity))
    # Each once, in the order of their first mention.
    return list(dict.fromkeys(found))
