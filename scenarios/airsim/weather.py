"""Fog and dust in pictures, and the wind."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flightsim.cameras import RgbdFrame
from flightsim.environment.wind import WindCfg, WindError
from flightsim.plant import Plant
from scenarios.airsim.frames import enu
from scenarios.airsim.messages import Vector3r
from scenarios.airsim.methods import RpcError
from scenarios.airsim.pictures import veiled

_NAMES = ("Rain", "Roadwetness", "Snow", "RoadSnow", "MapleLeaf", "RoadLeaf", "Dust", "Fog")
_DUST, _FOG, _ENABLED = 6, 7, 8
_DENSEST_1PM = {_FOG: -math.log(0.05) / 25.0, _DUST: -math.log(0.05) / 50.0}
"""Extinction at full strength: 5% of the contrast is left at 25 m of fog or 50 m of dust."""
_COLOURS = {_FOG: (204, 209, 214), _DUST: (196, 164, 120)}


class Weather:
    """Weather as clients have set it."""

    def __init__(self) -> None:
        self._is_enabled = False
        self._strengths: dict[int, float] = {}

    def enable(self, *, is_enabled: bool) -> None:
        """Show the weather or not."""
        self._is_enabled = is_enabled

    def set(self, parameter: int, strength: float) -> None:
        """Set fog or dust, from 0 to 1.

        Raises:
            RpcError: If there is no such weather here.
        """
        if parameter == _ENABLED:
            self._is_enabled = bool(strength)
            return
        if parameter not in _COLOURS:
            known = 0 <= parameter < len(_NAMES)
            name = _NAMES[parameter] if known else f"parameter {parameter}"
            raise RpcError(f"weather {name} is not offered; valid: Dust (6), Fog (7)")
        if not 0.0 <= strength <= 1.0:
            raise RpcError(f"{_NAMES[parameter]} {strength} is not valid; valid: 0 to 1")
        self._strengths[parameter] = strength

    def seen(self, frame: RgbdFrame) -> np.ndarray:
        """Colours of a picture in this weather."""
        rgb = frame.rgb
        for parameter, strength in self._strengths.items():
            if self._is_enabled and strength > 0.0:
                density = strength * _DENSEST_1PM[parameter]
                rgb = veiled(replace(frame, rgb=rgb), density, _COLOURS[parameter])
        return rgb


def set_wind(plants: list[Plant], wind: Vector3r) -> None:
    """Let a steady wind blow at all vehicles; turbulence and gusts stay what they are.

    Raises:
        RpcError: If it is too strong, or no wind at all.
    """
    try:
        steady = WindCfg.towards(enu(wind))
        for plant in plants:
            plant.wind = replace(
                plant.wind,
                speed_mps=steady.speed_mps,
                from_deg=steady.from_deg,
                up_mps=steady.up_mps,
            )
    except WindError as error:
        raise RpcError(str(error)) from None
