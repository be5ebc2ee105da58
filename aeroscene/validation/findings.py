"""Findings of the validation of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FindingKind = Literal["overlap", "floating", "outside", "unreachable", "unlandable"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One fault of a scene, and its place."""

    kind: FindingKind
    scene_id: str
    object_id: int | None = None
    """The object at fault, or the one that carries the area; None for the start."""
    area_id: int | None = None
    detail: str
    """One line with the figures that break the rule."""
