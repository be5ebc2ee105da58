"""The objects of a scene in the making: consecutive ids, parents before their children."""

from __future__ import annotations

from collections.abc import Mapping

from aeroscene.layouts.ground import Rectangle
from aeroscene.scene import AttributeValue, ObjectDomain, OrientedBox, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id


class Assembly:
    """Collects objects and numbers them."""

    def __init__(self, scene_id: str) -> None:
        self.scene_id = scene_id
        self.objects: list[SceneObject] = []

    def add(
        self,
        category: str,
        box: OrientedBox,
        domain: ObjectDomain,
        parent_id: int | None = None,
        attributes: Mapping[str, AttributeValue] | None = None,
    ) -> int:
        """Add an object; returns its id."""
        number = len(self.objects)
        self.objects.append(
            SceneObject(
                id=number,
                scene_id=self.scene_id,
                parent_id=parent_id,
                category_id=category_id(category),
                bbox=box,
                domain=domain,
                attributes=dict(attributes or {}),
            )
        )
        return number


def slab(rectangle: Rectangle, bottom_m: float, top_m: float) -> OrientedBox:
    """The box over a rectangle between two heights."""
    x0, y0, x1, y1 = rectangle
    centre = (round((x0 + x1) / 2, 4), round((y0 + y1) / 2, 4), round((bottom_m + top_m) / 2, 4))
    size = (round(x1 - x0, 4), round(y1 - y0, 4), round(top_m - bottom_m, 4))
    return OrientedBox(centre, (1.0, 0.0, 0.0, 0.0), size)


def upright_box(
    centre: tuple[float, float],
    heading_rad: float,
    size: tuple[float, float, float],
    bottom_m: float,
) -> OrientedBox:
    """A box that stands at a height, its x axis along a heading."""
    x, y = centre
    p = (round(x, 4), round(y, 4), round(bottom_m + size[2] / 2, 4))
    s = (round(size[0], 4), round(size[1], 4), round(size[2], 4))
    return OrientedBox(p, quat_from_yaw(heading_rad), s)
