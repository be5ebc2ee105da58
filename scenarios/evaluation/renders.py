"""The two pictures of a scene by which a network compares scenes, always taken in the same way.

| part | setting |
|---|---|
| size | 256 x 256 pixels |
| top | from straight above, field of view 40 degrees, north at the top |
| oblique | from the south-west (azimuth -118 degrees), 40 degrees up, field of view 40 degrees |
| scale | one for all scenes of a domain, such that 90% of the training scenes fit |
| middle | the origin of the scene, at the ground |
| roofs | indoors everything above 2.5 m is cut off, so that rooms can be seen |
| renderer | ray casting on the processor, quality `fast`: the same picture on every machine |
| vehicle, traffic | none |

All scenes of a domain share a scale, so that a room twice as large looks twice as large. If a
scene has rooms without a building about them, only the rooms count for the scale: the yard about
them is no part of what was learnt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from aeroscene.landform import level
from aeroscene.metrics.appearance.features import Picture
from aeroscene.scene import Scene, SceneDomain
from aeroscene.scene.catalogue import ROOMS
from autonomy.types import Vector3
from flightsim.cameras import open_camera_renderer
from flightsim.looks.cutting import cut_at
from flightsim.world import build_world

PIXELS = 256
_TOP_FOV_RAD = math.radians(40.0)
"""Field of view from above; with a narrower one the eye is so high that haze hides the ground."""
_OBLIQUE_FOV_RAD = math.radians(40.0)
_OBLIQUE_AZIMUTH_RAD = math.radians(-118.0)
_OBLIQUE_ELEVATION_RAD = math.radians(40.0)
_OBLIQUE_ROOM = 1.2
"""Factor on the distance, because near corners of a site need more room than its middle."""
_CUT_M = 2.5
_LEAST_M = 0.02
"""Thinnest rest of a box in these pictures. Floors of rooms are left out, because no method draws
what a floor is made of."""
_REACHED_SHARE = 0.9
_LEAST_REACH_M = 2.0


class Photographer(Protocol):
    """Camera that takes the same views of every scene."""

    @property
    def views(self) -> tuple[str, ...]:
        """Names of the pictures of a scene."""
        ...

    def pictures(self, scene: Scene) -> Sequence[Picture]:
        """Return the pictures of a scene, one for each of `views`."""
        ...


@dataclass(frozen=True)
class Camera:
    """Camera of colour pictures, from above and from aside, with one scale for each domain."""

    reach_m: Mapping[SceneDomain, float]
    """Half of the side of the picture, by domain."""

    @property
    def views(self) -> tuple[str, ...]:
        """Names of the pictures of a scene."""
        return ("top", "oblique")

    @classmethod
    def from_scenes(cls, train: Sequence[Scene]) -> Camera:
        """Return the camera whose scale suits training scenes.

        Args:
            train: Training scenes; scenes that are judged do not affect the scale.
        """
        reaches: dict[SceneDomain, list[float]] = {}
        for scene in train:
            reaches.setdefault(scene.domain, []).append(_reach_m(scene))
        return cls(
            {
                domain: max(float(np.quantile(each, _REACHED_SHARE)), _LEAST_REACH_M)
                for domain, each in reaches.items()
            }
        )

    def pictures(self, scene: Scene) -> tuple[Picture, Picture]:
        """Return the scene from above and from aside.

        Args:
            scene: Scene to photograph; a domain without training scenes takes the largest scale.

        Raises:
            ValueError: If its geometry does not compile.
        """
        # Without a theme nothing stands around the site, so that only the layout is compared.
        world = build_world(replace(level(scene), interaction_areas=(), theme=""))
        if scene.domain == "indoor":
            # Everything above is cut off, so that both views look into the rooms.
            world = replace(world, solids=cut_at(world.solids, _CUT_M, _LEAST_M))
        reach_m = self.reach_m.get(scene.domain, max(self.reach_m.values()))
        data = world.new_data()
        with closing(open_camera_renderer(world, PIXELS, PIXELS, "raycast")) as renderer:
            top, oblique = (
                renderer.render_view(data, eye, (0.0, 0.0, 0.0), fov_rad).rgb.copy()
                for eye, fov_rad in _eyes(reach_m)
            )
        return top, oblique


def _reach_m(scene: Scene) -> float:
    # Rooms without a parent are scenes of single rooms, which no building encloses.
    rooms = [obj for obj in scene.objects if obj.category in ROOMS and obj.parent_id is None]
    corners = np.concatenate([obj.bbox.corners() for obj in rooms or scene.objects])
    return float(np.abs(corners[:, :2]).max())


def _eyes(reach_m: float) -> tuple[tuple[Vector3, float], tuple[Vector3, float]]:
    # Half of the picture's side is the reach at the height of the ground.
    above_m = reach_m / math.tan(_TOP_FOV_RAD / 2)
    away_m = _OBLIQUE_ROOM * reach_m / math.tan(_OBLIQUE_FOV_RAD / 2)
    level_m = away_m * math.cos(_OBLIQUE_ELEVATION_RAD)
    oblique = (
        level_m * math.cos(_OBLIQUE_AZIMUTH_RAD),
        level_m * math.sin(_OBLIQUE_AZIMUTH_RAD),
        away_m * math.sin(_OBLIQUE_ELEVATION_RAD),
    )
    return ((0.0, 0.0, above_m), _TOP_FOV_RAD), (oblique, _OBLIQUE_FOV_RAD)
