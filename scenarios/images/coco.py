"""The annotations of a set as one COCO file.

Images lie beside it in `images/`. Each instance is an annotation with its box and its mask as run
lengths. Landing areas are annotations too, in categories of their own. Fields that COCO does not
know, such as poses and boxes in the world, are kept, because programs skip fields they do not know.
"""

from __future__ import annotations

import json
import tarfile
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from aeroscene import __version__
from aeroscene.files import replacing
from aeroscene.scene.catalogue import CATALOGUE
from aeroscene.scene.scene import DroneClass
from flightsim.cameras.segmentation import (
    CLASS_NAMES,
    DRONE_CLASS,
    PERSON_CLASS,
)
from scenarios.images.shard import IMAGES, ShardEntry, frame_key, images_name

COCO = "coco/annotations.json"
_FIRST_AREA = 101
AREA_CATEGORIES: Mapping[tuple[str, str], int] = {
    **{("landing", size): _FIRST_AREA + k for k, size in enumerate(get_args(DroneClass))},
    **{("perching", size): _FIRST_AREA + 3 + k for k, size in enumerate(get_args(DroneClass))},
}
"""Category of areas by their kind and the largest class of drone that fits."""


def categories() -> list[dict[str, Any]]:
    """Return all categories: the scene's, movers, and areas."""
    rows = [
        {"id": number, "name": kind.name, "supercategory": kind.level}
        for number, kind in CATALOGUE.items()
    ]
    rows += [
        {"id": number, "name": CLASS_NAMES[number], "supercategory": "mover"}
        for number in (PERSON_CLASS, DRONE_CLASS)
    ]
    rows += [
        {"id": number, "name": f"{kind} area, {size}", "supercategory": "area"}
        for (kind, size), number in AREA_CATEGORIES.items()
    ]
    return rows


def write_coco(folder: Path, shards: Sequence[ShardEntry]) -> None:
    """Write the annotations of all shards, whole or not at all.

    A set of 10,000 frames has some hundred thousand annotations: they are never all in memory.

    Args:
        folder: Folder of the set.
        shards: Its shards, in their order.
    """
    head = {
        "info": {"description": "AeroScene: labelled images", "version": __version__},
        "licenses": [],
        "categories": categories(),
    }
    path = folder / COCO
    with replacing(path) as file, tempfile.TemporaryFile(dir=path.parent) as later:
        file.write(json.dumps(head).encode()[:-1] + b',\n"images": [')
        n_images = n_annotations = 0
        for shard in shards:
            for facts in read_facts(folder / shard.file):
                file.write(b",\n" if n_images else b"\n")
                file.write(_line(_image(shard, facts)))
                n_images += 1
                for annotation in _annotations(facts):
                    # Numbers from 1 on: COCO's own evaluation takes 0 for "no match".
                    n_annotations += 1
                    later.write(b",\n" if n_annotations > 1 else b"\n")
                    later.write(_line({"id": n_annotations, **annotation}))
        file.write(b'\n],\n"annotations": [')
        later.seek(0)
        while piece := later.read(1 << 20):
            file.write(piece)
        file.write(b"\n]}\n")


def read_facts(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the facts of each frame of a shard, in its order."""
    with tarfile.open(path) as tar:
        for member in tar:
            if member.name.endswith(".json"):
                data = tar.extractfile(member)
                assert data is not None
                yield json.loads(data.read())


def _image(shard: ShardEntry, facts: Mapping[str, Any]) -> dict[str, Any]:
    folder = images_name(shard.shard).removeprefix(f"{IMAGES}/")
    known = {name: facts[name] for name in ("scene", "light", "season", "time_s", "height_m")}
    return {
        "id": facts["frame"],
        "file_name": f"{folder}/{frame_key(facts['frame'])}.jpg",
        "width": facts["camera"]["width_px"],
        "height": facts["camera"]["height_px"],
        **known,
        "camera": facts["camera"],
        "pose": facts["pose"],
    }


def _annotations(facts: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for each in facts["instances"]:
        more = {"instance": each["id"], "is_cut": each["is_cut"], "box3d": each["box3d"]}
        yield _annotation(facts, each, each["category_id"]) | more
    for each in facts["areas"]:
        category = AREA_CATEGORIES[each["kind"], each["drone_class"]]
        yield _annotation(facts, each, category) | {
            "area_id": each["id"],
            "polygons_px": each["polygons_px"],
            "centroid_px": each["centroid_px"],
            "share_seen": each["share_seen"],
        }


def _annotation(facts: Mapping[str, Any], each: Mapping[str, Any], category: int) -> dict[str, Any]:
    return {
        "image_id": facts["frame"],
        "category_id": category,
        "bbox": each["box_px"],
        "area": each["pixels"],
        "segmentation": each["rle"],
        "iscrowd": 0,
    }


def _line(row: Mapping[str, Any]) -> bytes:
    return json.dumps(row, separators=(",", ":")).encode()
