"""Contacts in a recording: the touched object, the time and the place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import rerun as rr

from scenarios.recording import layout
from scenarios.recording.columns import set_sim_time
from scenarios.recording.entity_stream import EntityStream

CONTACT_RGB, _RADIUS_M = (230, 60, 60), 0.06


def log_contacts(stream: EntityStream, contacts: Iterable[Mapping[str, Any]]) -> None:
    """Write contacts at their times, as text and as a point.

    Args:
        stream: Recording.
        contacts: Plain data of each `scenarios.trials.contacts.Contact`; needs time_s, until_s,
            what and position_enu_m.
    """
    for contact in contacts:
        set_sim_time(stream, round(1e6 * contact["time_s"]))
        # The time of the row is that of the first touch, so only the end is in words.
        words = f"{contact['what']}, until {contact['until_s']:.2f} s"
        stream.log(layout.TOUCHED, rr.TextLog(words))
        point = rr.Points3D(
            [contact["position_enu_m"]],
            colors=CONTACT_RGB,
            radii=_RADIUS_M,
            labels=[contact["what"]],
        )
        stream.log(layout.CONTACTS, point)
