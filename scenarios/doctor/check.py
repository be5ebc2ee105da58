"""What a check of this machine finds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Status = Literal["ok", "note", "problem"]

REINSTALL = "install aeroscene again: pip install --force-reinstall aeroscene"


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """One thing looked at."""

    name: str
    status: Status
    """note: works, though not all of it; problem: something essential does not."""
    value: str
    remedy: str = ""
    """What to do about it; empty where nothing needs doing."""
