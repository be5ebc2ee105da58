"""Scenes as programs: one tree of tokens that geometry alone turns into boxes."""

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
