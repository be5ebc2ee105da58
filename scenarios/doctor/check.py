"""Result of one check of this machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Status = Literal["ok", "note", "problem"]

REINSTALL = "install aeroscene again: pip install --force-reinstall aeroscene"


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """Result of one check."""

    name: str
    status: Status
    """Status: "ok", "note" if it works in part, "problem" if something essential fails."""
    value: str
    remedy: str = ""
    """Advice for the user; empty if none is needed."""


def judged(name: str, value: str, remedy: str, *, is_fine: bool, fault: Status = "note") -> Check:
    """Return the result of a check that is either fine or has a remedy.

    Args:
        name: Name of the check.
        value: Finding.
        remedy: Advice, which is shown only if there is a fault.
        is_fine: True if there is no fault.
        fault: Status if there is one.
    """
    status: Status = "ok" if is_fine else fault
    return Check(name=name, status=status, value=value, remedy="" if is_fine else remedy)
