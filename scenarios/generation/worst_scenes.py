"""Scenes in which a pilot does worst: each scene is flown once, and the worst flights decide.

Failed flights come first. Among failed flights and among the others, a flight is worse the larger
the sum of its ranks in landing error, time and least clearance. Ranks are used because the three
figures have different units. A missing figure has the worst rank, equal figures share theirs, and
the lower seed goes first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from aeroscene.files import replacing
from aeroscene.files.names import file_name
from aeroscene.scene import Scene
from aeroscene.scene.io import read_scene, write_scene
from scenarios.baselines.named import NamedPilot
from scenarios.generation.text_options import GenerateError

ORDER = (
    "failed first, then by the sum of ranks in touchdown_error_m, sim_seconds, least_clearance_m"
)
_SETTINGS = "asked.json"


@dataclass(frozen=True, kw_only=True)
class Flight:
    """Result of a pilot's flight in a scene."""

    seed: int
    success: bool
    reason: str
    touchdown_error_m: float | None = None
    sim_seconds: float | None = None
    least_clearance_m: float | None = None
    """Least distance between the vehicle's sphere and an obstacle along the path, except within
    1.5 m of the take-off and the place of rest."""


def fly(scene: Scene, pilot: NamedPilot) -> Flight:
    """Fly a scene with an Iris, seed 0 and no wind, as fast as the machine can.

    A pilot that raises an error, and a scene in which ours finds no mission, count as failed.

    Args:
        scene: Scene to fly in.
        pilot: Pilot to judge.

    Raises:
        INPUT_ERRORS: If the machine does not allow the flight, which says nothing of the pilot.
    """
    # The whole simulator, which only flying needs.
    from flightsim.testbench import TestbenchCfg
    from scenarios.mission.surroundings import MissionError
    from scenarios.run.cfg import SitlCfg
    from scenarios.run.input_errors import INPUT_ERRORS
    from scenarios.run.sitl import Sitl

    cfg = pilot.brief(SitlCfg(bench=TestbenchCfg(vehicle="iris", speed="max")))
    try:
        with Sitl(cfg, scene=scene, pilot=pilot.make, has_network=False) as sitl:
            result = sitl.run()
            return Flight(
                seed=scene.seed,
                success=bool(result.success),
                reason=result.reason,
                touchdown_error_m=result.touchdown_error_m,
                sim_seconds=result.sim_seconds,
                least_clearance_m=result.least_clearance_m,
            )
    except INPUT_ERRORS as error:
        # Only a missing mission is a property of the scene.
        if not isinstance(error.__cause__, MissionError):
            raise
        return Flight(seed=scene.seed, success=False, reason=str(error))
    except Exception as error:  # noqa: BLE001 - a user's pilot may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        return Flight(seed=scene.seed, success=False, reason=reason)


def worst_first(flights: Sequence[Flight]) -> list[Flight]:
    """Return flights in the order that `ORDER` states.

    Args:
        flights: Flights of different seeds.
    """
    badness = (
        [_bad(flight.touchdown_error_m) for flight in flights],
        [_bad(flight.sim_seconds) for flight in flights],
        # A small clearance is bad, hence the sign.
        [_bad(flight.least_clearance_m, -1.0) for flight in flights],
    )
    # Rank 0 is best; equal figures share the lower one.
    ranks = np.sum([np.searchsorted(np.sort(values), values) for values in badness], axis=0)
    totals = {flight.seed: int(rank) for flight, rank in zip(flights, ranks, strict=True)}
    return sorted(flights, key=lambda f: (f.success, -totals[f.seed], f.seed))


def _bad(figure: float | None, sign: float = 1.0) -> float:
    return math.inf if figure is None else sign * figure


class Tries:
    """Folder of scenes that were made and flown, so that no call does the work of another again."""

    def __init__(self, folder: Path, asked: dict[str, Any]) -> None:
        """Open or make a folder.

        Args:
            folder: Folder of the tries.
            asked: Options on which the scenes depend, apart from their seeds.

        Raises:
            GenerateError: If it holds tries of other options.
        """
        self.folder = folder
        path = folder / _SETTINGS
        text = msgspec.json.encode(asked)
        if path.exists() and path.read_bytes() != text:
            raise GenerateError(
                f"out {str(folder.parent)!r} holds tries of other wishes; valid: another folder, "
                f"or the options in {str(path)!r}"
            )
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(path) as file:
            file.write(text)

    def scene_path(self, seed: int) -> Path:
        """Return the file of a seed's scene, which may not exist yet."""
        return self.folder / f"aeroscene-{seed:04d}.json"

    def flight(self, seed: int, pilot: NamedPilot) -> Flight:
        """Return the flight in a seed's scene: read from the folder, or flown and written.

        Args:
            seed: Seed whose scene is in the folder.
            pilot: Pilot to fly if there is no flight yet.
        """
        # Flights are deterministic, so a written one is as good as a new one.
        path = self.folder / f"aeroscene-{seed:04d}.flight.json"
        if path.exists():
            return msgspec.json.decode(path.read_bytes(), type=Flight)
        flight = fly(read_scene(self.scene_path(seed)), pilot)
        with replacing(path) as file:
            file.write(msgspec.json.encode(flight) + b"\n")
        return flight

    def keep(self, flight: Flight, pilot: str, n_tried: int, out: Path) -> Path:
        """Write the scene of a flight into another folder, with the flight in its document.

        Args:
            flight: Flight to keep.
            pilot: Name of the pilot.
            n_tried: Number of scenes that were flown.
            out: Folder to write to.

        Returns:
            Path of the scene.
        """
        scene = read_scene(self.scene_path(flight.seed))
        figures = {f"flight_{name}": v for name, v in asdict(flight).items() if v is not None}
        del figures["flight_seed"]
        # The document then says by which selection its difficulty came about.
        wishes = {**scene.wishes, "worst_for": pilot, "of": n_tried}
        path = out / f"{file_name(scene.scene_id)}.json"
        write_scene(replace(scene, wishes=wishes, measured={**scene.measured, **figures}), path)
        return path
