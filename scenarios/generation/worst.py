"""Scenes in which a pilot does worst: each is flown once, the worst flights decide.

Failed flights come first. Among failed ones and among the others a flight is worse the larger the
sum of its ranks in landing error, time and least clearance; a figure that is missing has the worst
rank, equal ones share theirs, and the lower seed goes first.
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
from scenarios.generation.asked import GenerateError

ORDER = (
    "failed first, then by the sum of ranks in touchdown_error_m, sim_seconds, least_clearance_m"
)
_SETTINGS = "asked.json"


@dataclass(frozen=True, kw_only=True)
class Flight:
    """How a pilot fared in a scene."""

    seed: int
    success: bool
    reason: str
    touchdown_error_m: float | None = None
    sim_seconds: float | None = None
    least_clearance_m: float | None = None
    """Least distance between the vehicle's sphere and an obstacle on the way, 1.5 m and more from
    where it took off and came to rest."""


def fly(scene: Scene, pilot: NamedPilot) -> Flight:
    """Fly a scene with an Iris, seed 0 and no wind, as fast as it goes.

    A pilot that raises an error, and a scene in which ours finds no mission, count as failed.

    Raises:
        INPUT_ERRORS: If the machine does not allow the flight: then it says nothing of the pilot.
    """
    # The whole simulator: only where somebody flies.
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
        if not isinstance(error.__cause__, MissionError):
            raise
        return Flight(seed=scene.seed, success=False, reason=str(error))
    except Exception as error:  # noqa: BLE001 - a user's pilot may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        return Flight(seed=scene.seed, success=False, reason=reason)


def worst_first(flights: Sequence[Flight]) -> list[Flight]:
    """Flights in the order of `ORDER`."""
    badness = (
        [_bad(flight.touchdown_error_m) for flight in flights],
        [_bad(flight.sim_seconds) for flight in flights],
        [_bad(flight.least_clearance_m, -1.0) for flight in flights],
    )
    # Rank 0 is best; equal figures share the lower one.
    ranks = np.sum([np.searchsorted(np.sort(values), values) for values in badness], axis=0)
    totals = {flight.seed: int(rank) for flight, rank in zip(flights, ranks, strict=True)}
    return sorted(flights, key=lambda f: (f.success, -totals[f.seed], f.seed))


def _bad(figure: float | None, sign: float = 1.0) -> float:
    return math.inf if figure is None else sign * figure


class Tries:
    """Folder of scenes that were made and flown: what is there is not done again."""

    def __init__(self, folder: Path, asked: dict[str, Any]) -> None:
        """Open or make a folder.

        Raises:
            GenerateError: If it holds tries of something else.
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
        """File of the scene of a seed."""
        return self.folder / f"aeroscene-{seed:04d}.json"

    def flight(self, seed: int, pilot: NamedPilot) -> Flight:
        """The flight in the scene of a seed: read, or flown and written."""
        path = self.folder / f"aeroscene-{seed:04d}.flight.json"
        if path.exists():
            return msgspec.json.decode(path.read_bytes(), type=Flight)
        flight = fly(read_scene(self.scene_path(seed)), pilot)
        with replacing(path) as file:
            file.write(msgspec.json.encode(flight) + b"\n")
        return flight

    def keep(self, flight: Flight, pilot: str, n_tried: int, out: Path) -> Path:
        """Write the scene of a flight into another folder, with the flight in its document."""
        scene = read_scene(self.scene_path(flight.seed))
        figures = {f"flight_{name}": v for name, v in asdict(flight).items() if v is not None}
        del figures["flight_seed"]
        wishes = {**scene.wishes, "worst_for": pilot, "of": n_tried}
        path = out / f"{file_name(scene.scene_id)}.json"
        write_scene(replace(scene, wishes=wishes, measured={**scene.measured, **figures}), path)
        return path
