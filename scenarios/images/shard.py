"""Makes one shard: a tar file in the naming of WebDataset, and its images as files for COCO.

    shards/images-000012.tar          0000240.rgb.jpg, 0000240.depth.png ... 0000240.json ...
    coco/images/000012/0000240.jpg    the same JPEG again

The tar file is written last: if it is there, the shard is whole.
"""

from __future__ import annotations

import functools
import hashlib
import io
import json
import math
import shutil
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, get_args

import msgspec
import numpy as np

from aeroscene.corpus.provenance import curation_digest, sources_digest
from aeroscene.files import replacing
from flightsim.cameras import open_camera_renderer
from flightsim.draws import generator, seed_sequence
from flightsim.environment.traffic import TrafficCfg
from flightsim.looks.light import light_of
from flightsim.looks.weather import RANDOM, Season, Weather, draw_weather, parse_weather
from flightsim.world import build_world
from scenarios.images.encoding import encoded
from scenarios.images.frame import Labeller
from scenarios.images.place import Place, place_of
from scenarios.images.poses import Flight, draw_free
from scenarios.images.request import ImagesRequest, Shard

SHARDS, IMAGES = "shards", "coco/images"
_MOST_TIME_S = 120.0
"""Times of frames lie within this, during which movers go round."""


class ShardEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A finished shard in the manifest."""

    shard: int
    file: str
    """Path of the tar file below the set's folder."""
    sha256: str
    n_bytes: int
    first_frame: int
    n_frames: int
    sources: str
    """Digest of the code that made it."""


def tar_name(number: int) -> str:
    """Return the path of a shard's tar file below the set's folder."""
    return f"{SHARDS}/images-{number:06d}.tar"


def images_name(number: int) -> str:
    """Return the path of the folder of a shard's JPEG files below the set's folder."""
    return f"{IMAGES}/{number:06d}"


def frame_key(frame: int) -> str:
    """Return the name of a frame's files up to the first dot."""
    return f"{frame:07d}"


@functools.cache
def images_digest() -> str:
    """Return a digest that changes with all code that the pixels and labels follow from."""
    root = Path(__file__).parents[2]
    parts = [curation_digest()]
    parts += [
        sources_digest(root / name, ())
        for name in ("flightsim/looks", "flightsim/cameras", "flightsim/world", "scenarios/images")
    ]
    return hashlib.sha256("".join(parts).encode()).hexdigest()[:16]


def make_shard(folder: Path, request: ImagesRequest, shard: Shard) -> ShardEntry:
    """Make a shard and write its files; the same bytes on every call.

    Args:
        folder: Folder of the set, in which the folders of shards and images exist.
        request: The whole request.
        shard: Shard to make.

    Raises:
        SceneError: If the scene cannot be opened.
        ImagesError: If the scene cannot be shown.
        OSError: If a file cannot be written.
    """
    frames = dict(labelled(request, shard))
    _write_images(folder, shard.number, frames)
    path = folder / tar_name(shard.number)
    packed = _packed(frames)
    with replacing(path) as file:
        file.write(packed)
    return ShardEntry(
        shard=shard.number,
        file=tar_name(shard.number),
        sha256=hashlib.sha256(packed).hexdigest(),
        n_bytes=len(packed),
        first_frame=shard.first_frame,
        n_frames=shard.n_frames,
        sources=images_digest(),
    )


def labelled(request: ImagesRequest, shard: Shard) -> Iterator[tuple[int, dict[str, bytes]]]:
    """Yield the number of each frame of a shard, and its files by their endings."""
    place = place_of(shard.scene)
    scene = place.scene
    rng = generator(request.seed, scene.scene_id, "images", shard.number)
    weather = _weather(request, rng)
    width, height = request.sizes_px[int(rng.integers(len(request.sizes_px)))]
    # Each shard has paths of its own.
    words = seed_sequence(request.seed, scene.scene_id, "images", "traffic", shard.number)
    traffic = TrafficCfg.parse(request.traffic, int(words.generate_state(1)[0]))
    light = light_of(weather, scene.latitude_deg, scene.longitude_deg)
    world = build_world(scene, traffic=traffic, light=light)
    common = {
        "scene": scene.scene_id,
        "light": str(weather),
        "season": weather.season,
        "seed": request.seed,
    }
    flight = Flight(place, rng) if request.poses == "flights" else None
    with closing(open_camera_renderer(world, width, height)) as renderer:
        labeller = Labeller(world, renderer, width, height)
        for number in shard.frames:
            rng = generator(request.seed, scene.scene_id, "images", "frame", number)
            yield number, _take(request, place, flight, labeller, number, common, rng)


def _take(
    request: ImagesRequest,
    place: Place,
    flight: Flight | None,
    labeller: Labeller,
    number: int,
    common: dict[str, Any],
    rng: np.random.Generator,
) -> dict[str, bytes]:
    """Take a frame, and return its files by their endings."""
    after_s = request.next_after_s
    poses = draw_free(place, after_s, rng) if flight is None else flight.draw(after_s, rng)
    fov_rad = math.radians(rng.uniform(*request.fov_deg))
    frame = labeller.take(poses, fov_rad, rng.uniform(0.0, _MOST_TIME_S), after_s)
    height_m = round(place.height_m(poses.now.position_enu_m), 3)
    facts = {"frame": number, **common, "height_m": height_m, **frame.facts}
    return {**encoded(frame), "json": json.dumps(facts, separators=(",", ":")).encode()}


def _weather(request: ImagesRequest, rng: np.random.Generator) -> Weather:
    """Return the shard's light and weather; both draws are made, whether they are used or not."""
    drawn: Season = get_args(Season)[int(rng.integers(len(get_args(Season))))]
    season = drawn if request.season == RANDOM else request.season
    random = draw_weather(rng, season)  # pyrefly: ignore[bad-argument-type]
    if request.light == RANDOM:
        return random
    return parse_weather(request.light, season)  # pyrefly: ignore[bad-argument-type]


def _packed(frames: dict[int, dict[str, bytes]]) -> bytes:
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for number, files in frames.items():
            for suffix, data in files.items():
                # A fresh header names no time and no user, so that equal frames give equal bytes.
                member = tarfile.TarInfo(f"{frame_key(number)}.{suffix}")
                member.size = len(data)
                tar.addfile(member, io.BytesIO(data))
    return packed.getvalue()


def _write_images(folder: Path, number: int, frames: dict[int, dict[str, bytes]]) -> None:
    """Write the JPEG files of a shard into a folder of their own, whole or not at all."""
    wanted = folder / images_name(number)
    unfinished = Path(tempfile.mkdtemp(dir=wanted.parent, prefix=f".{wanted.name}."))
    try:
        for frame, files in frames.items():
            (unfinished / f"{frame_key(frame)}.jpg").write_bytes(files["rgb.jpg"])
        # Temporary folders are private to their owner.
        unfinished.chmod(0o755)
        shutil.rmtree(wanted, ignore_errors=True)
        unfinished.replace(wanted)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
