"""Scenes as programs: one tree of tokens that geometry alone turns into boxes.

A list of boxes that a network draws has gaps and overlaps of centimetres, which are visible at
once. A program names relations instead: this wall is a border of that room, this chair stands at
that table. Boxes follow from it by geometry, so walls meet exactly. `encode` writes a scene as a
program, and `decode` builds a scene from any program.
"""

from aeroscene.learning.program.decoding.cfg import DecodingCfg
from aeroscene.learning.program.decoding.decode import decode
from aeroscene.learning.program.encoding.cfg import WHOLE, EncodingCfg
from aeroscene.learning.program.encoding.encode import EncodedProgram, encode
from aeroscene.learning.program.kinds import Kind
from aeroscene.learning.program.program import Program, ProgramError

__all__ = [
    "WHOLE",
    "DecodingCfg",
    "EncodedProgram",
    "EncodingCfg",
    "Kind",
    "Program",
    "ProgramError",
    "decode",
    "encode",
]
