"""Calls that draw into AirSim's window. There is none, so they are accepted and draw nothing."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from typing import Any

_LOG = logging.getLogger(__name__)

DRAWING = (
    "simSetTraceLine",
    "simFlushPersistentMarkers",
    "simPlotPoints",
    "simPlotLineStrip",
    "simPlotLineList",
    "simPlotArrows",
    "simPlotStrings",
    "simPlotTransforms",
    "simPlotTransformsWithNames",
)
"""Methods that draw."""


class DrawingCalls:
    """Accepts every call that draws, and reports each method once."""

    def __init__(self) -> None:
        self._reported: set[str] = set()

    @property
    def functions(self) -> Mapping[str, Callable[..., object]]:
        """All methods."""
        return {name: self._accept(name) for name in DRAWING}

    def _accept(self, name: str) -> Callable[..., None]:
        def accept(
            a: Any = None,
            b: Any = None,
            c: Any = None,
            d: Any = None,
            e: Any = None,
            f: Any = None,
            g: Any = None,
        ) -> None:
            _ = a, b, c, d, e, f, g
            if name not in self._reported:
                self._reported.add(name)
                _LOG.warning("AirSim: %s draws nothing: there is no window", name)

        return accept
