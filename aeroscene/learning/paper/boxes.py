"""Boxes with categories, and the scene document that they become.

The paper's layouts are flat lists without a tree. A scene needs parents and looks as well, so this
module finds a parent for each fine object and draws its look.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from jaxtyping import Float, Int

from aeroscene.learning.paper.layouts import NO_REGION, turned
from aeroscene.learning.paper.looks import Look, Looks
from aeroscene.learning.program.flight import extent_of, start_pad, top_of, yaw_inwards
from aeroscene.scene import OrientedBox, Scene, SceneDomain, SceneObject
from aeroscene.scene.box import MIN_SIZE_M, quat_from_yaw
from aeroscene.scene.catalogue import COARSE_COUNT
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG


@dataclass(frozen=True, eq=False)
class FlatBoxes:
    """Upright boxes in the world, in any order."""

    category: Int[np.ndarray, " n"]
    """Numbers of the catalogue, from 1."""
    center_enu_m: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    size_m: Float[np.ndarray, "n 3"]
    """Full extents."""
    region: Int[np.ndarray, " n"] | None = None
    """Row of the coarse object that each fine one belongs to, or `NO_REGION`; None if unknown."""

    def turned(self, yaw_rad: float) -> Self:
        """Turn the boxes about the origin, counter-clockwise seen from above."""
        center_enu_m = turned(self.center_enu_m, yaw_rad)
        return replace(self, center_enu_m=center_enu_m, yaw_rad=self.yaw_rad + yaw_rad)

    def scene(
        self, domain: SceneDomain, looks: Looks, scene_id: str, seed: int, rng: np.random.Generator
    ) -> Scene:
        """Build a scene of two levels from the boxes, without interaction areas.

        A fine object without a region belongs to the smallest coarse one that it is in, seen from
        above, so that a chair by a wall belongs to the room. An object that is in none belongs to
        the coarse one with the nearest centre, as in the paper's coarse-to-fine guidance.

        Args:
            domain: Domain of the scene.
            looks: Looks of the training scenes. A category without a look becomes the first one
                with a look.
            scene_id: Name of the scene.
            seed: Seed that the scene states.
            rng: Draws the looks.

        Raises:
            SceneError: If a number is not finite.
        """
        boxes = self._coarse_first(looks)
        assert boxes.region is not None
        objects: list[SceneObject] = []
        shared: dict[tuple[int, int], Look] = {}
        for i, (category, parent) in enumerate(zip(boxes.category, boxes.region, strict=True)):
            # Objects of one category in one room look alike, such as its chairs.
            key = int(category), int(parent)
            look = shared.get(key) or looks.draw(key[0], rng)
            if look.is_shared:
                shared[key] = look
            objects.append(
                SceneObject(
                    id=i,
                    scene_id=scene_id,
                    parent_id=None if parent == NO_REGION else key[1],
                    category_id=key[0],
                    bbox=boxes._box(i),
                    domain=look.domain,
                    attributes=dict(look.attributes),
                )
            )
        low, high = extent_of(objects, domain)
        pad = start_pad(objects)
        # Without a pad the flight starts at the origin.
        start = np.clip((0.0, 0.0, 0.0) if pad is None else top_of(pad), low, high).tolist()
        return Scene(
            scene_id=scene_id,
            domain=domain,
            seed=seed,
            extent_min_enu_m=low,
            extent_max_enu_m=high,
            start_position_enu_m=tuple(start),
            start_yaw_rad=yaw_inwards(start),
            latitude_deg=LATITUDE_DEG,
            longitude_deg=LONGITUDE_DEG,
            altitude_m=ALTITUDE_M,
            objects=tuple(objects),
        )

    def _coarse_first(self, looks: Looks) -> Self:
        """Sort the boxes into a scene's order, with known categories and a region each."""
        is_known = looks.is_known
        category = np.where(is_known[self.category], self.category, is_known.argmax())
        is_coarse = category <= COARSE_COUNT
        order = np.argsort(~is_coarse, kind="stable")
        center, n_coarse = self.center_enu_m[order], int(is_coarse.sum())
        region = np.full(len(order), NO_REGION)
        if self.region is not None:
            # Row that each old row moves to; the last entry keeps `NO_REGION`,
            # which is -1, in its place.
            place = np.append(np.argsort(order), NO_REGION)
            region[n_coarse:] = place[self.region[order]][n_coarse:]
        elif n_coarse:
            region[n_coarse:] = _regions(center, self.size_m[order], self.yaw_rad[order], n_coarse)
        return replace(
            self,
            category=category[order],
            center_enu_m=center,
            yaw_rad=self.yaw_rad[order],
            size_m=self.size_m[order],
            region=region,
        )

    def _box(self, row: int) -> OrientedBox:
        return OrientedBox(
            # Places to tenths of a millimetre, extents to millimetres.
            tuple(np.round(self.center_enu_m[row], 4).tolist()),
            quat_from_yaw(float(self.yaw_rad[row])),
            tuple(np.maximum(np.round(self.size_m[row], 3), MIN_SIZE_M).tolist()),
        )


def _regions(
    center_enu_m: Float[np.ndarray, "n 3"],
    size_m: Float[np.ndarray, "n 3"],
    yaw_rad: Float[np.ndarray, " n"],
    n_coarse: int,
) -> Int[np.ndarray, " fine"]:
    """Find the coarse object that each fine one belongs to, if the layout does not state it."""
    offset = center_enu_m[n_coarse:, None] - center_enu_m[None, :n_coarse]
    cos, sin = np.cos(yaw_rad[:n_coarse]), np.sin(yaw_rad[:n_coarse])
    along = np.abs(cos * offset[..., 0] + sin * offset[..., 1])
    across = np.abs(cos * offset[..., 1] - sin * offset[..., 0])
    half_m = size_m[:n_coarse] / 2
    is_in = (along <= half_m[:, 0]) & (across <= half_m[:, 1])
    # There is no upper limit: objects high above a coarse object still belong to it.
    is_in &= offset[..., 2] >= -half_m[:, 2]
    area = np.where(is_in, half_m[:, 0] * half_m[:, 1], np.inf)
    nearest = np.linalg.norm(offset, axis=-1).argmin(axis=1)
    return np.where(is_in.any(axis=1), area.argmin(axis=1), nearest)
