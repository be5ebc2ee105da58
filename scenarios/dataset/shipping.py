"""Scenes that ship: drawn until they are sound, kept in a folder and packed into one file.

Users fly these scenes before they generate any, so each must be flyable, and each must be the scene
that `gen:N` gives with the same checkpoint. The archive records its provenance: checkpoint, code,
libraries, and the attempt that each scene came from.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import aeroscene
from aeroscene.corpus.corpus import CORPUS_SIZE, scene_domain
from aeroscene.corpus.dataset import Dataset, DatasetError, SceneEntry, store_scene
from aeroscene.corpus.provenance import sources_digest
from aeroscene.corpus.shipped import Provenance, write_archive
from aeroscene.scene import Scene
from scenarios.bench.soundness import fault
from scenarios.dataset.build import BuildPlan, plan_folder

if TYPE_CHECKING:
    from aeroscene.learning.generation import Generator

MOST_ATTEMPTS = 20
_DIGEST_LENGTH = 16


class Maker(Protocol):
    """Source of scenes by number."""

    @property
    def name(self) -> str:
        """Name of the maker."""
        ...

    @property
    def checkpoint(self) -> str:
        """SHA-256 of the weights; empty for a maker without weights."""
        ...

    def draw(self, number: int, attempt: int) -> Scene | None:
        """Draw a scene; the result depends on the arguments alone.

        Args:
            number: Number of the scene, which is its seed.
            attempt: Number of the attempt, from 0.

        Returns:
            The scene, or None if the draw is rejected.
        """
        ...


@dataclass(frozen=True, slots=True)
class ModelMaker:
    """The trained model, one scene at a time, so that scene N equals `gen:N`."""

    path: Path
    """File of the checkpoint."""
    device: str

    @property
    def name(self) -> str:
        """Name of the maker."""
        return f"model {self.path.stem}"

    @property
    def checkpoint(self) -> str:
        """SHA-256 of the weights' file.

        Raises:
            OSError: If it cannot be read.
        """
        return hashlib.sha256(self.path.read_bytes()).hexdigest()

    def draw(self, number: int, attempt: int) -> Scene | None:
        """Draw a scene of the number's domain, or None if it is not feasible.

        Raises:
            SceneError: If checkpoint or device cannot be used.
        """
        from aeroscene.learning.generation import Request

        request = Request(seed=number, domain=scene_domain(number))
        return next(_generator(self.path, self.device).generate([request], attempt=attempt)).scene


@cache
def _generator(checkpoint: Path, device: str) -> Generator:
    """Return the generator of this process, with one thread, because processes share the cores."""
    import torch

    from aeroscene.learning.generation import Generator

    torch.set_num_threads(1)
    return Generator.load(checkpoint, device=device)


@dataclass(frozen=True, slots=True)
class CorpusMaker:
    """The curated corpus in place of the model, to rehearse shipping without a checkpoint."""

    name: str = "curation"
    checkpoint: str = ""

    def draw(self, number: int, attempt: int) -> Scene | None:
        """Return the scene of the corpus at the first attempt, and None at further ones."""
        # Curation has one scene for each number, so another attempt could not differ.
        from aeroscene.corpus.curation import curate_scene

        return curate_scene(number) if attempt == 0 else None


def plan_shipped(folder: Path, numbers: tuple[int, ...], maker: Maker) -> BuildPlan:
    """Plan the build of the scenes that ship.

    Args:
        folder: Folder to build in.
        numbers: Numbers of the scenes.
        maker: Source of the scenes.

    Raises:
        DatasetError: If the folder's manifest cannot be read.
        OSError: If the weights cannot be read.
    """
    sources = _sources(maker)
    return plan_folder(folder, numbers, partial(make_sound_scene, folder, maker, sources), sources)


def _sources(maker: Maker) -> str:
    digest = hashlib.sha256(f"{maker.name} {maker.checkpoint} {code_digest()}".encode())
    return digest.hexdigest()[:_DIGEST_LENGTH]


@cache
def code_digest() -> str:
    """Return the digest of the sources that determine a model's scene for a seed."""
    # Reading of layouts and of shipped scenes does not affect what the model draws.
    return sources_digest(
        Path(aeroscene.__file__).parent, ("layouts", "corpus/shipped.py", "sources.py")
    )


def make_sound_scene(folder: Path, maker: Maker, sources: str, number: int) -> SceneEntry:
    """Draw a scene until it is sound and a vehicle can stand at its start, and write its file.

    Args:
        folder: Folder of the dataset.
        maker: Source of the scenes.
        sources: Digest that the entry records.
        number: Number of the scene.

    Returns:
        Entry of the scene for the manifest.

    Raises:
        DatasetError: If no attempt succeeds.
    """
    reason = "was not feasible"
    for attempt in range(MOST_ATTEMPTS):
        scene = maker.draw(number, attempt)
        if scene is None:
            continue
        found = fault(scene)
        if found is None:
            return store_scene(folder, scene, number, sources, attempt)
        reason = f"is not: {found}"
    raise DatasetError(
        f"scene {number}: none of {MOST_ATTEMPTS} draws is sound, the last {reason}; "
        "valid: a better checkpoint"
    )


def pack_shipped(
    dataset: Dataset, path: Path, maker: Maker, device: str, on_scene: Callable[[], object]
) -> int:
    """Write the archive of the scenes that ship.

    Args:
        dataset: All scenes to ship.
        path: File of the archive.
        maker: Maker of the scenes.
        device: Device on which they were made.
        on_scene: Called after each scene.

    Returns:
        Size of the archive, bytes.

    Raises:
        DatasetError: If a scene is missing, or was made by something else.
        SceneError: If a scene cannot be read.
        OSError: If the archive cannot be written.
    """
    sources = _sources(maker)
    # Scenes of another checkpoint or another code would not be those of `gen:N`.
    ready = {entry.index for entry in dataset.entries if entry.sources == sources}
    if ready != set(range(CORPUS_SIZE)):
        raise DatasetError(
            f"{CORPUS_SIZE - len(ready)} scenes are missing in {str(dataset.place)!r} or were made "
            "by something else; valid: all of them from one checkpoint"
        )
    provenance = Provenance(
        generator=maker.name,
        checkpoint=maker.checkpoint,
        code=f"{version('aeroscene')}+{code_digest()}",
        environment=_environment(device),
        attempts={entry.index: entry.attempt for entry in dataset.entries if entry.attempt},
    )

    # Scenes are read one at a time, since all of them would fill the memory.
    def told():
        for scene in dataset.scenes():
            yield scene
            on_scene()

    return write_archive(path, told(), provenance)


def _environment(device: str) -> dict[str, str]:
    libraries = {name: version(name) for name in ("numpy", "scipy", "shapely", "torch")}
    return {
        "device": device,
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **libraries,
    }
