"""Configuration of the encoding."""

from __future__ import annotations

import msgspec


class EncodingCfg(msgspec.Struct, frozen=True, kw_only=True):
    """What programs say of scenes; taken away, it shows what it brings.

    Checkpoints keep it: what a model completes is encoded as its training was.
    """

    has_partitions: bool = True
    """Whether covers, rooms and walls are read as parts of the site and of storeys. Else each of
    them is an object by itself, with a place and a size."""
    has_relations: bool = True
    """Whether objects are read by what they are to their hosts, rows and grids at once. Else each
    of them has a place in the frame of what bears it."""


WHOLE = EncodingCfg()
"""All of it, as programs are."""
