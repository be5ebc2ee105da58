"""Result of a check of this machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Status = Literal["ok", "note", "problem"]

REINSTALL = "install aeroscene again: pip install --force-reinstall aeroscene"


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """One checked item."""

    name: str
    status: Status
    """Status: note if it works in part; problem if something essential fails."""
    value: str
    remedy: str = ""
    """Remedy; empty if none is needed."""


def judged(name: str, value: str, remedy: str, *, is_fine: bool, fault: Status = "note") -> Check:
    """An item that is fine, or has a fault and a remedy."""
    status: Status = "ok" if is_fine else fault
    return Check(name=name, status=status, value=value, remedy="" if is_fine else remedy)
