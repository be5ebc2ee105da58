"""OpenStreetMap's binary form, read by `osmium`; only elements in the bounds are kept.

A country's extract has gigabytes, a town's some tens of megabytes. Nodes come first in such files,
so one pass cannot know which of them later ways need. The file is therefore read several times: for
nodes and elements that touch the bounds, for the nodes of these elements, and for their contents.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aeroscene.maps.bounds import Bounds
from aeroscene.maps.document import MapError
from aeroscene.maps.osm_data import OsmData, Relation, Way

MOST_PBF_BYTES = 512 << 20
_AREAS = frozenset({"multipolygon", "boundary"})


def read_osm_pbf(path: Path, where: str, bounds: Bounds | None) -> OsmData:
    """Read the elements of a PBF file that touch some bounds, whole.

    Args:
        path: File.
        where: Name of the file in errors.
        bounds: Bounds of the elements to keep. None keeps everything, which only suits small files.

    Raises:
        MapError: If it cannot be read, or osmium is not installed.
    """
    try:
        import osmium
        import osmium.io
    except ImportError:
        raise MapError(
            f"{where} needs osmium; valid: pip install 'aeroscene[maps]', or the map as .osm or "
            ".geojson"
        ) from None
    size = path.stat().st_size
    if size > MOST_PBF_BYTES:
        raise MapError(
            f"{where} holds {size >> 20} MiB; valid: at most {MOST_PBF_BYTES >> 20} MiB, cut it "
            "out with osmium extract"
        )
    data = OsmData()
    try:
        near = _touching(osmium, path, bounds)
        _fill(osmium, path, data, *near)
        box = osmium.io.Reader(str(path)).header().box()
        if box.valid():
            low, high = box.bottom_left, box.top_right
            data.bounds = Bounds(low.lon, low.lat, high.lon, high.lat)
    except (RuntimeError, ValueError, OSError) as error:
        # Our own errors are ValueErrors too.
        if isinstance(error, MapError):
            raise error.within(where) from None
        reason = " ".join(str(error).split())
        raise MapError(f"{where} cannot be read ({reason}); valid: a whole PBF file") from None
    return data


def _touching(
    osmium: Any, path: Path, bounds: Bounds | None
) -> tuple[set[int], set[int], set[int]]:
    """Ways and relations with a node in the bounds, and the nodes that they need."""
    inside: set[int] = set()
    ways: set[int] = set()
    relations: set[int] = set()
    needed: set[int] = set()
    for obj in osmium.FileProcessor(str(path)):
        if obj.is_node():
            if bounds is None or _is_inside(obj.location, bounds):
                inside.add(obj.id)
        elif obj.is_way():
            if any(node.ref in inside for node in obj.nodes):
                # A relation follows its ways in the file, so that they are known.
                ways.add(obj.id)
        elif obj.tags.get("type") in _AREAS and any(
            m.type == "w" and m.ref in ways for m in obj.members
        ):
            relations.add(obj.id)
            needed |= {m.ref for m in obj.members if m.type == "w"}
    # Ways outside of the bounds complete the rings of relations.
    ways |= needed
    nodes = set(inside)
    for obj in osmium.FileProcessor(str(path), osmium.osm.WAY):
        if obj.id in ways:
            nodes |= {node.ref for node in obj.nodes}
    return nodes, ways, relations


def _is_inside(location: Any, bounds: Bounds) -> bool:
    if not location.valid():
        return False
    is_within = bounds.west <= location.lon <= bounds.east
    return is_within and bounds.south <= location.lat <= bounds.north


def _fill(
    osmium: Any, path: Path, data: OsmData, nodes: set[int], ways: set[int], relations: set[int]
) -> None:
    for obj in osmium.FileProcessor(str(path)):
        kept = nodes if obj.is_node() else ways if obj.is_way() else relations
        if obj.id not in kept:
            continue
        where = f"{'node' if obj.is_node() else 'way' if obj.is_way() else 'relation'} {obj.id}"
        tags: dict[str, str] = {}
        for tag in obj.tags:
            data.add_tag(tags, tag.k, tag.v, where)
        if obj.is_node():
            data.add_node(obj.id, obj.location.lon, obj.location.lat)
            if tags:
                data.node_tags[obj.id] = tags
        elif obj.is_way():
            data.ways[obj.id] = way = Way(tags=tags)
            for node in obj.nodes:
                data.add_reference(way, node.ref, where)
        else:
            data.relations[obj.id] = relation = Relation(tags=tags)
            for m in obj.members:
                kind = {"n": "node", "w": "way", "r": "relation"}.get(m.type, "")
                data.add_reference(relation, (kind, m.ref, m.role), where)
