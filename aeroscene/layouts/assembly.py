"""Objects of a scene in the making: consecutive ids, parents before their children."""

from __future__ import annotations

from collections.abc import Mapping

from aeroscene.layouts.ground import Rectangle
from aeroscene.scene import AttributeValue, ObjectDomain, OrientedBox, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import category_id


class Assembly:
    """Objects in the order of their ids."""

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
        """Add an object, and return its id.

        Args:
            category: Name of our category.
            box: Box of the object.
            domain: Indoor or outdoor.
            parent_id: Id of an object that was added before.
            attributes: Attributes of the object.
        """
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
    """Box over a rectangle between two heights, rounded to 4 decimals."""
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
    """Upright box that stands at a height, its x axis along a heading.

    Args:
        centre: East and north of its middle, m.
        heading_rad: Heading of the x axis.
        size: Full extents, m.
        bottom_m: Height of its underside.
    """
    x, y = centre
    p = (round(x, 4), round(y, 4), round(bottom_m + size[2] / 2, 4))
    s = (round(size[0], 4), round(size[1], 4), round(size[2], 4))
    return OrientedBox(p, quat_from_yaw(heading_rad), s)
