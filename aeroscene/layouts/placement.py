"""The source's own objects in our scene: under their parents, with their original names."""

from __future__ import annotations

from aeroscene.layouts.document import LayoutObject
from aeroscene.layouts.house import ROOF_M
from aeroscene.layouts.mapping import form_of
from aeroscene.layouts.site import KeptObject, Site
from aeroscene.scene import AttributeValue, ObjectDomain, OrientedBox, SceneObject
from aeroscene.scene.catalogue import ROOMS
from aeroscene.scene.hanging import PENDANT

_ROOFED = ("building", "house")
"""Categories whose upper part becomes a roof of its own."""
_HANGS_M = 0.5
"""Height of the underside from which an unsupported lamp hangs from the ceiling."""


def place_objects(site: Site) -> None:
    """Place each object under its parent, its nearest kept ancestor, or the room around it."""
    objects = site.layout.objects
    rooms = [obj for obj in site.assembly.objects if obj.category in ROOMS]
    contained = {obj.parent for obj in objects}
    ids: dict[int, int] = {}
    for index, kept in site.kept.items():
        parent = objects[index].parent
        # A parent that was left out passes its contents on to its own parent.
        while parent is not None and parent not in ids:
            parent = objects[parent].parent
        parent_id = _room_of(kept.box, rooms) if parent is None else ids[parent]
        domain = _domain(site, parent_id)
        attributes = _attributes(objects[index], kept)
        # A building that contains objects can be entered.
        if kept.category in _ROOFED and index in contained:
            attributes["is_enterable"] = True
        ids[index] = _add(site, kept, domain, parent_id, attributes)


def _add(
    site: Site,
    kept: KeptObject,
    domain: ObjectDomain,
    parent_id: int | None,
    attributes: dict[str, AttributeValue],
) -> int:
    box = kept.box
    if attributes.get("form") == PENDANT and parent_id is not None:
        box = _hung(box, site.assembly.objects[parent_id].bbox)
    # A body needs some height below its roof.
    if kept.category not in _ROOFED or not box.is_upright or box.s[2] < 4 * ROOF_M:
        return site.assembly.add(kept.category, box, domain, parent_id, attributes)
    (x, y, z), (depth, width, height) = box.p, box.s
    body = OrientedBox((x, y, z - ROOF_M / 2), box.q, (depth, width, height - ROOF_M))
    roof = OrientedBox((x, y, z + (height - ROOF_M) / 2), box.q, (depth, width, ROOF_M))
    number = site.assembly.add(kept.category, body, domain, parent_id, attributes)
    site.assembly.add("roof", roof, domain, number, {"form": "flat"})
    return number


def _hung(box: OrientedBox, room: OrientedBox) -> OrientedBox:
    """A lamp with its cord up to the ceiling, which is higher here than in the source."""
    low_m, ceiling_m = box.p[2] - box.s[2] / 2, room.p[2] + room.s[2] / 2
    if not box.is_upright or ceiling_m <= low_m:
        return box
    height_m = round(ceiling_m - low_m, 4)
    return OrientedBox((*box.p[:2], low_m + height_m / 2), box.q, (*box.s[:2], height_m))


def _domain(site: Site, parent_id: int | None) -> ObjectDomain:
    """Domain of an object: indoors in a layout of rooms or in a building, else outdoors."""
    if site.is_indoor:
        return "indoor"
    if parent_id is None:
        return "outdoor"
    parent = site.assembly.objects[parent_id]
    return "indoor" if parent.category in _ROOFED else parent.domain


def _attributes(obj: LayoutObject, kept: KeptObject) -> dict[str, AttributeValue]:
    """Attributes of an object: its name in the source, and the closest form of our shape."""
    attributes: dict[str, AttributeValue] = {"source_category": obj.category}
    if obj.name and obj.name != obj.category:
        attributes["source_name"] = obj.name
    form = form_of(obj.category)
    if kept.category in _ROOFED:
        form = "plain"
    elif kept.category == "garage":
        form = "garage"
    elif kept.category == "lamp" and obj.parent is None and kept.low_m > _HANGS_M:
        form = PENDANT
    if form is not None:
        attributes["form"] = form
    return attributes


def _room_of(box: OrientedBox, rooms: list[SceneObject]) -> int | None:
    """The room whose floor lies below the middle of a box."""
    for room in rooms:
        if all(abs(box.p[i] - room.bbox.p[i]) <= room.bbox.s[i] / 2 for i in range(2)):
            return room.id
    return None
