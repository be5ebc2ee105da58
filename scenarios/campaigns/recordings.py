"""Where the parts of a campaign's folder are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from aeroscene.files.names import file_name
from scenarios.run.levels import RecordLevel

MANIFEST = "campaign.json"
"""File in the folder of a campaign that says what it is of."""
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
        return self.folder / f"{file_name(trial_id, 'trial')}.rrd"
