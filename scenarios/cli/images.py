"""`aeroscene images`: labelled images by the thousand, as COCO and as shards for WebDataset."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from aeroscene.processes import WorkerDiedError, default_jobs
from aeroscene.ranges import SEEDS, Range
from scenarios.cli.command_line import EXIT_DONE, default_hint, fail, interrupt, print_json
from scenarios.cli.outputs import OutFile, OutFolder
from scenarios.cli.progress import progress_bar
from scenarios.cli.scene_numbers import SceneNumbersError, scene_numbers
from scenarios.images.request import (
    MOST_FRAMES,
    MOST_PER_LIGHT,
    ImagesError,
    ImagesRequest,
    PoseSource,
    parse_fov,
    parse_sizes,
    require_bounded,
    require_shipped,
)

if TYPE_CHECKING:
    from scenarios.images.build import ImagesPlan

_PROG = "aeroscene images"
_JOBS = Range(1, 512)
_NUMBERS = frozenset("0123456789:")


@dataclass(frozen=True, kw_only=True)
class ImagesCfg:
    """Make images with labels: depth, normals, optical flow, masks, boxes, landing areas, poses.

    Poses, lenses, light and weather are drawn by the seed: the same command makes the same bytes,
    with any number of processes. If you stop it, the same command continues it. OUT/shards has tar
    files for WebDataset, OUT/coco a COCO file with its images; see docs/images.md.
    """

    out: Annotated[Path, OutFolder()]
    """Folder of the images; it is made if it is missing."""
    scenes: str = "0:10"
    """Numbers of scenes of the dataset: A:B without B, single ones; or names such as corpus:7,
    gen:7, field or house.json; joined by commas."""
    count: Annotated[int, Range(1, MOST_FRAMES)] = 200
    """Number of frames, divided evenly over the scenes."""
    size: str = "640x480"
    """Width and height of the images in pixels, 32 to 4096 each and 8,294,400 in all; of several,
    joined by commas, each shard draws one."""
    fov: str = "60:100"
    """Field of view from left to right in degrees, 10 to 150: one number, or LOW:HIGH, of which
    each frame draws one."""
    poses: PoseSource = "free"
    """Poses of the cameras: free draws them in free space; flights takes them along paths from and
    to landing areas."""
    light: str = "random"
    """Light and weather of all frames, such as "dusk, fog 80 m", see docs/light.md; random draws
    them for each shard."""
    season: Literal["random", "spring", "summer", "autumn", "winter"] = "random"
    """Season of all frames; random draws it for each shard."""
    traffic: str = "none"
    """Movers in each scene, such as people=3,cars=2,drones=1."""
    frames_per_light: Annotated[int, Range(1, MOST_PER_LIGHT)] = 20
    """Most frames of a scene in one light, which are a shard. Fewer vary more and take longer."""
    next_after: Annotated[float, Range(0.01, 1.0, "s")] = 0.1
    """Time from each frame to its second image, to which optical flow leads."""
    seed: Annotated[int, SEEDS] = 0
    """Seed of all draws."""
    sheet: Annotated[Path | None, OutFile((".png",)), default_hint("none")] = None
    """Also draw a contact sheet of 8 frames with their labels into this PNG file."""
    jobs: Annotated[int, _JOBS] = field(default_factory=default_jobs)
    """Processes; the default is the number of cores."""
    json: bool = False
    """Print one JSON object: folder, frames, made, kept, shards, bytes, seconds."""


def run(cfg: ImagesCfg) -> int:
    """Make the frames that are missing or outdated, and print how many were made and kept.

    Returns:
        0. Bad input or an unusable folder ends the process with status 2 and one line.
    """
    # SIGTERM is handled as Ctrl-C is, so that nothing stays half-written.
    signal.signal(signal.SIGTERM, interrupt)
    try:
        return _build(cfg, request_of(cfg))
    except (ImagesError, SceneNumbersError, WorkerDiedError) as error:
        fail(_PROG, str(error))


def request_of(cfg: ImagesCfg) -> ImagesRequest:
    """Read the options, before anything heavy is loaded.

    Raises:
        ImagesError: If sizes, field of view or scenes are not valid.
        SceneNumbersError: If a range of scenes is malformed.
        WeatherError: If light or season are.
        TrafficError: If the traffic is.
    """
    request = ImagesRequest(
        scenes=_scenes(cfg.scenes),
        count=cfg.count,
        seed=cfg.seed,
        sizes_px=parse_sizes(cfg.size),
        fov_deg=parse_fov(cfg.fov),
        light=cfg.light,
        season=cfg.season,
        poses=cfg.poses,
        traffic=cfg.traffic,
        frames_per_light=cfg.frames_per_light,
        next_after_s=cfg.next_after,
    )
    require_bounded(request)
    from flightsim.looks.weather import RANDOM, parse_weather

    if request.light != RANDOM:
        parse_weather(request.light)
    if request.traffic != "none":
        from flightsim.environment.traffic import TrafficCfg

        TrafficCfg.parse(request.traffic, 0)
    return request


def _scenes(text: str) -> tuple[str, ...]:
    """Return the names of the scenes; those that are no numbers are opened, to be sure of them."""
    parts = text.split(",")
    named = [part for part in parts if not part or not _NUMBERS.issuperset(part)]
    numbered = [part for part in parts if part not in named]
    if not numbered and not any(named):
        scene_numbers(text)  # refuses an empty text
    numbers = scene_numbers(",".join(numbered)) if numbered else ()
    require_shipped(numbers, text)
    if named:
        from aeroscene.sources import load_scene

        for name in named:
            load_scene(name)
    return (*map(str, numbers), *dict.fromkeys(named))


def _build(cfg: ImagesCfg, request: ImagesRequest) -> int:
    # Imported here because it is the whole simulator, which a refusal should not cost.
    from scenarios.images.build import build_images, plan_images
    from scenarios.images.sheet import write_sheet

    plan = plan_images(cfg.out, request)
    if plan.n_outdated:
        sys.stderr.write(
            f"{_PROG}: {plan.n_outdated} shards in {cfg.out} were made by other sources: "
            "they are made again\n"
        )
    start_s = time.perf_counter()
    try:
        with progress_bar("taking images", plan.n_frames, "frames") as advance:
            manifest = build_images(plan, cfg.jobs, advance)
    except KeyboardInterrupt:
        sys.stderr.write(f"{_PROG}: stopped; the same command goes on from here\n")
        raise
    if cfg.sheet is not None:
        write_sheet(cfg.out, cfg.sheet)
    n_bytes = sum(entry.n_bytes for entry in manifest.shards)
    _report(cfg, plan, len(manifest.shards), n_bytes, time.perf_counter() - start_s)
    return EXIT_DONE


def _report(cfg: ImagesCfg, plan: ImagesPlan, n_shards: int, n_bytes: int, seconds: float) -> None:
    n_made = plan.n_frames
    n_kept = plan.request.count - n_made
    if cfg.json:
        print_json(
            {
                "folder": str(cfg.out),
                "frames": plan.request.count,
                "made": n_made,
                "kept": n_kept,
                "shards": n_shards,
                "bytes": n_bytes,
                "seconds": round(seconds, 3),
            }
        )
        return
    rate = f", {60 * n_made / seconds:.0f} a minute" if n_made else ""
    print(
        f"{cfg.out}: {plan.request.count} frames in {n_shards} shards, {n_bytes / 1e6:.1f} MB. "
        f"{n_made} made in {seconds:.1f} s{rate}, {n_kept} were there."
    )
