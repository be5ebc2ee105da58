"""PLAY_TUNE_V2, which the dialects that come with pymavlink lack."""

# ruff: noqa: RUF012 - lists of a class, as pymavlink declares them

from __future__ import annotations

import struct
from typing import Any

from pymavlink.dialects.v20 import development as dialect


class PlayTuneV2(dialect.MAVLink_message):
    """A tune in one of the formats of TUNE_FORMAT; members are named as pymavlink wants them."""

    id = 400
    msgname = "PLAY_TUNE_V2"
    fieldnames = ["format", "target_system", "target_component", "tune"]
    ordered_fieldnames = fieldnames
    fieldtypes = ["uint32_t", "uint8_t", "uint8_t", "char"]
    orders = [0, 1, 2, 3]
    lengths = [1, 1, 1, 1]
    array_lengths = [0, 0, 0, 248]
    crc_extra = 110
    unpacker = struct.Struct("<IBB248s")

    def __init__(
        self,
        format: int,  # noqa: A002 - the field's name
        target_system: int,
        target_component: int,
        tune: bytes,
    ) -> None:
        super().__init__(self.id, self.msgname)
        self._fieldnames = self.fieldnames
        self.format = format
        self.target_system = target_system
        self.target_component = target_component
        self.tune = tune

    def pack(self, mav: Any, force_mavlink1: bool = False) -> bytes:
        """Frame of the message."""
        values = (self.format, self.target_system, self.target_component, self.tune)
        return self._pack(mav, self.crc_extra, self.unpacker.pack(*values), force_mavlink1)
