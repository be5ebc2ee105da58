"""Codec: meaning of a token's channels, each choice a switch.

The default is the table of `aeroscene.learning.tokens.channels`. The other choices are there to be
measured, see docs/notebook.md: guidance, and the borders that the network sees, read the default's
channels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, kw_only=True)
class CodecCfg:
    """Frame and scale of places, headings and sizes."""

    frame: Literal["play", "parent", "scene"] = "play"
    """Places along the parent's axes over the free play there; over half its extents; or along the
    axes of the site over half its extents."""
    yaw: Literal["vector", "angle"] = "vector"
    """Cosine and sine; or, below a site, quarter turns from -2 to 2 in the channel of the sine."""
    size: Literal["log", "linear"] = "log"
    """Extents as logarithms; or as they are, m or shares of the parent's."""

    def extents(self, log_size: Float[np.ndarray, "*n"]) -> Float[np.ndarray, "*n"]:
        """Channels of extents, or of ratios, from their logarithms."""
        return log_size if self.size == "log" else np.exp(log_size)


DEFAULT_CODEC = CodecCfg()


def quarter_turns(yaw_rad: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Angles in quarter turns, from -2 to below 2."""
    return np.mod(yaw_rad / (np.pi / 2) + 2, 4) - 2
