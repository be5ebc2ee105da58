"""Names of the files in a campaign's folder, and the options of its recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from aeroscene.files.names import file_name
from scenarios.run.levels import RecordLevel

MANIFEST = "campaign.json"
"""File in the folder of a campaign that holds its suite and version."""
RECORDINGS = "recordings"
"""Folder of recordings within a campaign's folder."""


@dataclass(frozen=True, kw_only=True)
class Recordings:
    """Folder and contents of the recordings of trials."""

    folder: Path
    level: RecordLevel = "full"
    camera_hz: float = 5.0
    """Frames of each camera in a simulated second."""

    def path(self, trial_id: str) -> Path:
        """Return the file of a trial's recording; the name is safe for every file system."""
        return self.folder / f"{file_name(trial_id, 'trial')}.rrd"
