"""`aeroscene export`: a scene as a file that other programs open."""

from __future__ import annotations

import time
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Literal

from scenarios.cli.command_line import EXIT_DONE, fail, print_json
from scenarios.cli.outputs import OutFolder
from scenarios.cli.terminal import styled, terminal

_PROG = "aeroscene export"
_NO_VEHICLE = "none"


@dataclass(frozen=True, kw_only=True)
class ExportCfg:
    """Write a scene as MJCF, GLB or USD, with its vehicle, landing areas and labels.

    mjcf opens in MuJoCo, glb in glTF viewers and game engines (looks and hierarchy, no physics),
    usd in Isaac Sim 5 and everything that reads USD (pip install usd-core).
    """

    to: Literal["mjcf", "glb", "usd"]
    """Format of the file."""
    out: Annotated[Path, OutFolder()]
    """Folder to write into; it is made if it is missing."""
    scene: str = "42"
    """Scene of the dataset by number, corpus:N, gen:SEED, district:SEED, field, a scene file,
    one of a file of layouts, or a place on a map as FILE.osm#W,S,E,N."""
    vehicle: str = "iris"
    """Airframe at the start: its name, a file FILE.toml that describes it, or none. An unknown name
    gets the valid ones as an answer. A GLB has no vehicle."""
    json: bool = False
    """Print one JSON object: file, format, scene, objects, areas, bytes, seconds."""


def run(cfg: ExportCfg) -> int:
    """Write the scene in the format that is asked for, and print the file's name and size.

    Returns:
        0. A scene that cannot be written ends the process with status 2 and one line.
    """
    # Imported here because it is the whole simulator, which `--help` does not need.
    from aeroscene.sources import load_scene
    from flightsim.export.files import ExportError
    from flightsim.vehicles.catalogue import airframe_by_name
    from flightsim.world import build_world

    began_s = time.perf_counter()
    airframes = [airframe_by_name(cfg.vehicle)] if cfg.vehicle != _NO_VEHICLE else []
    world = build_world(load_scene(cfg.scene), *airframes)
    # By name, so that only the format that is asked for needs its library, such as usd-core.
    write = getattr(import_module(f"flightsim.export.{cfg.to}"), f"write_{cfg.to}")
    try:
        path = write(world, cfg.out)
    except ExportError as error:
        fail(_PROG, str(error))
    facts = {
        "file": str(path),
        "format": cfg.to,
        "scene": world.scene.scene_id,
        "objects": len(world.scene.objects),
        "areas": len(world.scene.interaction_areas),
        "bytes": path.stat().st_size,
        "seconds": round(time.perf_counter() - began_s, 3),
    }
    if cfg.json:
        print_json(facts)
    else:
        figures = (
            f"  {facts['objects']} objects, {facts['areas']} areas, "
            f"{path.stat().st_size / 1e6:.1f} MB, {facts['seconds']:.1f} s"
        )
        terminal().print(styled((path, "bold"), figures), soft_wrap=True)
    return EXIT_DONE
