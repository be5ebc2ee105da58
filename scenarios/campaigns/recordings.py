"""Where the recordings of trials are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from scenarios.run.levels import RecordLevel

RECORDINGS = "recordings"
"""Folder of recordings in that of a campaign."""


@dataclass(frozen=True, kw_only=True)
class Recordings:
    """Where trials are recorded, and what of them."""

    folder: Path
    level: RecordLevel = "full"
    camera_hz: float = 5.0
    """Frames of each camera in a simulated second."""

    def path(self, trial_id: str) -> Path:
        """File of a trial's recording."""
        return self.folder / f"{trial_id.replace('/', '-')}.rrd"
