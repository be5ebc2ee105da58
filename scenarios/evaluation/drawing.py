"""Scenes of a method, which are drawn, projected and photographed one by one, and kept.

OUT/methods/NAME/training/          as `aeroscene train` leaves it
OUT/methods/NAME/scenes/0007.*      .sampled.json.gz, .projected.json.gz, .npz with features, .json

The .json with facts is written last. A draw that has it is complete and is not made again, so a
stopped table continues where it was.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from jaxtyping import Float
from shapely.errors import ShapelyError

from aeroscene.feasibility import make_feasible
from aeroscene.files import replacing
from aeroscene.metrics.appearance.features import FeatureNetwork, Picture
from aeroscene.scene import Scene, SceneDomain, SceneError
from aeroscene.scene.io import read_scene, write_scene
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from scenarios.evaluation.renders import Photographer

SAMPLED, PROJECTED = "sampled", "projected"
STAGES = (SAMPLED, PROJECTED)
_CLEAR_REFS = Path("/proc/self/clear_refs")
_STATUS = Path("/proc/self/status")


class DrawFacts(msgspec.Struct, frozen=True, kw_only=True):
    """Facts of one draw, which are kept beside its scenes."""

    seed: int
    failure: str | None = None
    """Reason why no scene could be drawn."""
    rejection: str | None = None
    """Reason why the projection rejected it, or why it does not compile with a vehicle."""
    n_areas: int = 0
    """Landing areas that can be reached."""
    sample_cpu_s: float = 0.0
    peak_mb: float = 0.0
    """Greatest memory of the process during the sampling; since the start of the process if the
    system cannot measure a part of it."""
    lands: bool | None = None
    """True if the demo landed; None if it was not flown."""


@dataclass(frozen=True, eq=False)
class Draw:
    """One draw of a method, as kept."""

    facts: DrawFacts
    stem: Path

    def scene(self, stage: str) -> Scene | None:
        """Return the scene of a stage, None if there is none.

        Args:
            stage: One of `STAGES`.
        """
        path = self.stem.with_suffix(f".{stage}.json.gz")
        return read_scene(path) if path.exists() else None

    def features(self, stage: str) -> Float[np.ndarray, "views f"] | None:
        """Return the features of the scene's pictures, None if there is no scene.

        Args:
            stage: One of `STAGES`.
        """
        with np.load(self.stem.with_suffix(".npz"), allow_pickle=False) as file:
            return file.get(stage, None)


class Drawer:
    """Draws scenes into a folder."""

    def __init__(
        self,
        folder: Path,
        network: FeatureNetwork,
        camera: Photographer,
        domains: Sequence[SceneDomain],
    ) -> None:
        """Open the folder of a method's scenes.

        Args:
            folder: Folder of the scenes; it is made if it is missing.
            network: Network that turns pictures into features.
            camera: Camera that takes the pictures.
            domains: Domains of the scenes, in turn: draw number i has that of test scene i.
        """
        self._folder, self._network, self._camera = folder, network, camera
        self._domains = domains
        folder.mkdir(parents=True, exist_ok=True)

    def missing(self, count: int) -> list[int]:
        """Return the numbers of the draws that are missing, of the first `count`."""
        return [i for i in range(count) if not self._stem(i).with_suffix(".json").exists()]

    def drawn(self, count: int) -> Iterator[Draw]:
        """Yield the draws that exist, of the first `count`."""
        for number in range(count):
            stem = self._stem(number)
            path = stem.with_suffix(".json")
            if path.exists():
                yield Draw(msgspec.json.decode(path.read_bytes(), type=DrawFacts), stem)

    def draw(
        self,
        number: int,
        seed: int,
        sample: Callable[[int, SceneDomain], Scene],
        *,
        is_real: bool = False,
    ) -> None:
        """Make one draw and keep it; a failure of the method is kept as a fact.

        Args:
            number: Number of the draw.
            seed: Seed of the draw.
            sample: The method: from seed and domain to a scene as sampled.
            is_real: True for a real scene, which is not projected.

        Raises:
            OSError: If a file cannot be written.
        """
        # Only sampling is timed: projection and pictures are the same for all methods.
        _forget_peak()
        start_s = time.process_time()
        try:
            sampled = sample(seed, self._domains[number % len(self._domains)])
        # Geometry that cannot be built is a result of the method, not a fault of the table.
        except (SceneError, ShapelyError, ValueError) as error:
            self._keep(number, DrawFacts(seed=seed, failure=" ".join(str(error).split())), {})
            return
        cpu_s, peak_mb = time.process_time() - start_s, _peak_mb()
        projected, rejection = (sampled, None) if is_real else _projected(sampled)
        rejection = rejection or _fault(projected)
        scenes = {SAMPLED: sampled} if is_real else {SAMPLED: sampled, PROJECTED: projected}
        if rejection is not None:
            # Only the sampled scene is judged; the reason stays among the facts.
            scenes.pop(PROJECTED, None)
        facts = DrawFacts(
            seed=seed,
            rejection=rejection,
            n_areas=0 if rejection else len(projected.landing_areas),
            sample_cpu_s=cpu_s,
            peak_mb=peak_mb,
        )
        self._keep(number, facts, scenes)

    def amend(self, draw: Draw, facts: DrawFacts) -> None:
        """Replace the facts of a draw, for example when it was flown later.

        Args:
            draw: Draw that was kept.
            facts: Its new facts.

        Raises:
            OSError: If the file cannot be written.
        """
        with replacing(draw.stem.with_suffix(".json")) as file:
            file.write(msgspec.json.encode(facts))

    def _keep(self, number: int, facts: DrawFacts, scenes: dict[str, Scene]) -> None:
        stem = self._stem(number)
        features: dict[str, Any] = {}
        for stage, scene in scenes.items():
            write_scene(scene, stem.with_suffix(f".{stage}.json.gz"))
            pictures: Sequence[Picture] = self._camera.pictures(scene)
            features[stage] = self._network.features(pictures)
        # Facts come last, because they mark the draw as complete.
        with replacing(stem.with_suffix(".npz")) as file:
            np.savez_compressed(file, **features)
        with replacing(stem.with_suffix(".json")) as file:
            file.write(msgspec.json.encode(facts))

    def _stem(self, number: int) -> Path:
        return self._folder / f"{number:04d}"


def _projected(sampled: Scene) -> tuple[Scene, str | None]:
    feasible = make_feasible(sampled)
    return feasible.scene, feasible.report.rejection


def _fault(scene: Scene) -> str | None:
    """Return why a vehicle cannot stand at the start, or has nothing to land on; None if it can."""
    if not scene.landing_areas:
        return "no landing area"
    try:
        build_world(scene, airframe_by_name("iris"))
    except ValueError as error:
        return " ".join(str(error).split())
    return None


def _forget_peak() -> None:
    """Let the system measure the peak of the memory from now on, if it can."""
    # Linux: writing 5 resets the peak (VmHWM) of the process, see proc(5).
    try:
        _CLEAR_REFS.write_text("5")
    except OSError:
        return


def _peak_mb() -> float:
    try:
        for line in _STATUS.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    except OSError:
        pass
    # Without /proc only the peak since the start of the process is known.
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # Kilobytes on Linux, bytes on macOS.
    return peak / 2**20 if sys.platform == "darwin" else peak / 1024
