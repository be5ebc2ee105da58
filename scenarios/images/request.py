"""Contents of a set of images that a user asks for, and its division into shards.

A shard is the unit of work: frames of one scene in one light. Building a world and baking its light
takes about two seconds, which the frames of a shard share. Each shard draws from random streams of
its own, so that its bytes depend on the request and its number alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

from aeroscene.corpus.corpus import CORPUS_SIZE

PoseSource = Literal["free", "flights"]
MOST_FRAMES = 1_000_000
MOST_PER_LIGHT = 200
MOST_PIXELS_OF_IMAGE = 3840 * 2160
MOST_PIXELS = 10**12
"""Most pixels of a whole set, each frame counted once: three million frames of 640 by 480."""
MOST_OBJECT_ID = 60_000
"""Greatest id of an object: images of instances have 16 bits, in which ids below zero wrap around.
"""
MOST_PIXELS_OF_SHARD = 200_000_000
"""Most pixels of a shard, which is in memory until it is whole: about 1 GB with all labels."""
LEAST_EDGE, MOST_EDGE = 32, 4096
FOV_DEG = (10.0, 150.0)
"""Narrowest and widest field of view from left to right."""


class ImagesError(ValueError):
    """Images cannot be made or read; one line says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Shard:
    """Frames of one scene in one light."""

    number: int
    scene: str
    """Name of the scene, as `aeroscene.sources.load_scene` takes it."""
    first_frame: int
    """Number of its first frame in the whole set."""
    n_frames: int

    @property
    def frames(self) -> range:
        """Numbers of its frames in the whole set."""
        return range(self.first_frame, self.first_frame + self.n_frames)


@dataclass(frozen=True, kw_only=True, slots=True)
class ImagesRequest:
    """All that the bytes of a set of images follow from, beside the code."""

    scenes: tuple[str, ...]
    """Names of scenes, as `aeroscene.sources.load_scene` takes them."""
    count: int
    """Number of frames, divided evenly over the scenes."""
    seed: int = 0
    sizes_px: tuple[tuple[int, int], ...] = ((640, 480),)
    """Widths and heights; each shard draws one."""
    fov_deg: tuple[float, float] = (60.0, 100.0)
    """Range of the field of view from left to right; each frame draws one."""
    light: str = "random"
    """Light and weather as `parse_weather` reads them, or "random": each shard draws one."""
    season: str = "random"
    """A season, or "random"."""
    poses: PoseSource = "free"
    traffic: str = "none"
    """Movers as `TrafficCfg.parse` reads them."""
    frames_per_light: int = 20
    """Most frames of a shard."""
    next_after_s: float = 0.1
    """Time between a frame and its second image, to which optical flow leads."""

    def shards(self) -> Iterator[Shard]:
        """Yield all shards, scene by scene, so that a process can keep what it knows of a scene."""
        number = first = 0
        each, more = divmod(self.count, len(self.scenes))
        for index, scene in enumerate(self.scenes):
            left = each + (index < more)
            while left:
                n_frames = min(left, self.frames_per_light)
                yield Shard(number=number, scene=scene, first_frame=first, n_frames=n_frames)
                number, first, left = number + 1, first + n_frames, left - n_frames

    def to_plain(self) -> dict[str, Any]:
        """Return the request as JSON knows it: lists for tuples."""
        plain = asdict(self)
        plain["scenes"] = list(self.scenes)
        plain["sizes_px"] = [list(size) for size in self.sizes_px]
        plain["fov_deg"] = list(self.fov_deg)
        return plain


def parse_sizes(text: str) -> tuple[tuple[int, int], ...]:
    """Read sizes of images, such as "640x480,1280x720".

    Raises:
        ImagesError: If one is malformed or too large.
    """
    sizes: list[tuple[int, int]] = []
    for part in text.split(","):
        width, x, height = part.strip().partition("x")
        is_size = x and width.isdecimal() and height.isdecimal() and len(part) < 12
        size = (int(width), int(height)) if is_size else (0, 0)
        if not all(LEAST_EDGE <= edge <= MOST_EDGE for edge in size):
            raise ImagesError(
                f"size {part!r} is not valid; valid: WIDTHxHEIGHT, such as 640x480, "
                f"{LEAST_EDGE} to {MOST_EDGE} pixels each, several joined by commas"
            )
        if size[0] * size[1] > MOST_PIXELS_OF_IMAGE:
            raise ImagesError(
                f"size {part!r} has {size[0] * size[1]:,} pixels; "
                f"valid: at most {MOST_PIXELS_OF_IMAGE:,}, as 3840x2160 has"
            )
        sizes.append(size)
    return tuple(dict.fromkeys(sizes))


def parse_fov(text: str) -> tuple[float, float]:
    """Read a field of view, such as "90", or a range, such as "60:100", in degrees.

    Raises:
        ImagesError: If it is malformed or out of range.
    """
    low, colon, high = text.partition(":")
    try:
        ends = (float(low), float(high if colon else low))
    except ValueError:
        ends = (0.0, 0.0)
    if not FOV_DEG[0] <= ends[0] <= ends[1] <= FOV_DEG[1]:
        raise ImagesError(
            f"fov {text!r} is not valid; valid: degrees from left to right, one number or "
            f"LOW:HIGH, from {FOV_DEG[0]:g} to {FOV_DEG[1]:g}"
        )
    return ends


def require_bounded(request: ImagesRequest) -> None:
    """Refuse a set with too many pixels, in all or in a shard.

    Raises:
        ImagesError: If it has more than `MOST_PIXELS`, or a shard may have more than
            `MOST_PIXELS_OF_SHARD`.
    """
    largest = max(width * height for width, height in request.sizes_px)
    if request.frames_per_light * largest > MOST_PIXELS_OF_SHARD:
        raise ImagesError(
            f"frames-per-light {request.frames_per_light} by {largest:,} pixels is too much "
            f"memory; valid: at most {MOST_PIXELS_OF_SHARD // largest} frames of that size"
        )
    if request.count * largest > MOST_PIXELS:
        raise ImagesError(
            f"count {request.count} by {largest:,} pixels is {request.count * largest:.1e} pixels; "
            f"valid: at most {MOST_PIXELS:.0e}, {MOST_PIXELS // largest} frames of that size"
        )


def require_shipped(numbers: tuple[int, ...], text: str) -> None:
    """Refuse numbers of scenes that do not ship.

    Raises:
        ImagesError: If there is one.
    """
    if numbers and numbers[-1] >= CORPUS_SIZE:
        raise ImagesError(
            f"scenes {text!r} has no scene {numbers[-1]}; valid: 0:{CORPUS_SIZE}, "
            "or corpus:N for others"
        )
