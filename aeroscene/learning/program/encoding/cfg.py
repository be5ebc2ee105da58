"""Configuration of the encoding."""

from __future__ import annotations

import msgspec


class EncodingCfg(msgspec.Struct, frozen=True, kw_only=True):
    """Details of scenes that programs keep; an ablation leaves one out.

    Checkpoints store it, so that a scene to complete is encoded as the training scenes were.
    """

    has_partitions: bool = True
    """True reads covers, rooms and walls as parts of the site and of storeys. Otherwise each is an
    object by itself, with a place and a size."""
    has_relations: bool = True
    """True reads objects by their relation to a host, and rows and grids as one. Otherwise each has
    a place in the frame of its bearer."""


WHOLE = EncodingCfg()
"""The full encoding."""
