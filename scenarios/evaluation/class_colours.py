"""Pictures as DiffuScene's authors take them, so that figures can stand beside theirs.

| part | setting |
|---|---|
| view | from straight above, parallel rays, 256 x 256 pixels |
| scale | 6.2 m from border to border, everything beyond is cut off |
| middle | middle of the room's floor |
| objects | furniture alone, on white: neither floor nor walls |
| colours | one a class, evenly about the circle of hues; no texture |

They draw meshes from 3D-FUTURE, whose licence does not let us copy them; here an object is the box
about it. Source: Tang et al. 2024, "DiffuScene", section 5.1, and the settings of its public
scripts.
"""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from PIL import Image, ImageDraw
from shapely import MultiPoint

from aeroscene.metrics.appearance.features import Picture
from aeroscene.scene import Scene, SceneObject
from aeroscene.scene.catalogue import ROOMS
from scenarios.evaluation.renders import PIXELS

HALF_M = 3.1
"""Half of the side of the picture."""
_FINER = 4
"""Factor by which pictures are drawn larger and then reduced, so that edges are smooth."""
_LIGHTNESS, _SATURATION = 0.6, 0.65
"""Lightness and saturation of seaborn's palette `hls`, which the authors use."""
_WHITE = (255, 255, 255)


@dataclass(frozen=True)
class ClassPictures:
    """Camera of these pictures, which knows the colour of each class."""

    classes: tuple[str, ...]
    """Categories of furniture in the training scenes, in the order of their names."""

    @classmethod
    def from_scenes(cls, train: Sequence[Scene]) -> ClassPictures:
        """Return the camera with a colour for each category of the training scenes.

        Args:
            train: Training scenes; the colours depend on them alone, and not on what is judged.
        """
        found = {obj.category for scene in train for obj in _furniture(scene)}
        return cls(tuple(sorted(found)))

    @property
    def views(self) -> tuple[str, ...]:
        """Names of the pictures of a scene."""
        return ("top",)

    def pictures(self, scene: Scene) -> tuple[Picture]:
        """Return the scene from above, 256 x 256 pixels.

        Args:
            scene: Scene of one room; categories that no training scene has are grey.
        """
        side_px = PIXELS * _FINER
        image = Image.new("RGB", (side_px, side_px), _WHITE)
        draw = ImageDraw.Draw(image)
        middle_m = _floor_middle_m(scene)
        # The painter's algorithm: objects with a higher top cover the others.
        for obj in sorted(_furniture(scene), key=_top_m):
            place = (_outline_m(obj) - middle_m) / (2 * HALF_M)
            # Pixels count downwards, north points up.
            corners_px = np.column_stack([0.5 + place[:, 0], 0.5 - place[:, 1]]) * side_px
            draw.polygon([(x, y) for x, y in corners_px.tolist()], fill=self._colour(obj.category))
        return (np.asarray(image.resize((PIXELS, PIXELS), Image.Resampling.BOX)),)

    def _colour(self, category: str) -> tuple[int, int, int]:
        if category not in self.classes:
            return (128, 128, 128)
        # The offset of 0.01 is seaborn's.
        hue = 0.01 + self.classes.index(category) / len(self.classes)
        rgb = colorsys.hls_to_rgb(hue % 1.0, _LIGHTNESS, _SATURATION)
        red, green, blue = (round(255 * share) for share in rgb)
        return red, green, blue


def _furniture(scene: Scene) -> list[SceneObject]:
    return [obj for obj in scene.objects if not obj.is_coarse]


def _top_m(obj: SceneObject) -> float:
    return obj.bbox.p[2] + obj.bbox.s[2] / 2


def _outline_m(obj: SceneObject) -> np.ndarray:
    """Return the corners of the box seen from above, in order, east and north."""
    return shapely.get_coordinates(MultiPoint(obj.bbox.corners()[:, :2]).convex_hull)


def _floor_middle_m(scene: Scene) -> np.ndarray:
    rooms = [obj for obj in scene.objects if obj.category in ROOMS]
    if not rooms:
        return np.zeros(2)  # the origin of the layout
    corners = np.concatenate([obj.bbox.corners()[:, :2] for obj in rooms])
    return (corners.min(axis=0) + corners.max(axis=0)) / 2
