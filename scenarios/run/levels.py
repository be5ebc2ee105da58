"""Levels of a recording, which command lines name before the simulator is loaded."""

from __future__ import annotations

from typing import Literal

RecordLevel = Literal["summary", "state", "interaction", "full"]
"""Contents of a recording, from little to all; docs/recording.md has the table."""
