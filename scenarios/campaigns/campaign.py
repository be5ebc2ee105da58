"""A campaign in its folder: its suite, the trials that are there, and those left to fly.

A campaign takes hours and may be interrupted at any time. Its folder therefore says what it is of,
so that the same command continues it, and a command with other options is refused instead of mixing
results.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import msgspec
import pyarrow.compute as pc

from aeroscene import __version__
from aeroscene.corpus.shipped import shipped_digest
from aeroscene.files import read_bounded, replacing
from aeroscene.files.bounds import MOST_CONFIG_BYTES
from scenarios.campaigns.engines.crew import Crew, Engine
from scenarios.campaigns.equipment import Equipment, equipment_from
from scenarios.campaigns.flight_stack import stack_from
from scenarios.campaigns.flyer import Row, Suite, Trial
from scenarios.campaigns.recordings import MANIFEST
from scenarios.campaigns.store import JOURNAL, Store, open_store, read_results
from scenarios.campaigns.summary import SUMMARY_COLUMNS, summarise_trials
from scenarios.chat.completions import ChatModel
from scenarios.tasks.recipe import recipe_from

SUMMARY = "summary.json"  # in the folder of a campaign


class CampaignError(ValueError):
    """A campaign cannot be flown in a folder; one line says why, and what would be valid."""


class _SuiteFacts(msgspec.Struct, kw_only=True):
    recipe: dict[str, Any]
    families: dict[str, dict[str, Any]] = {}
    pilot: str
    program: str | None = None
    endpoint: str | None = None
    model: str | None = None
    autopilot: Literal["px4", "ardupilot"] | None = None
    autopilot_binary: str = ""
    autopilot_sha256: str = ""
    policy_sha256: str = ""
    equipment: dict[str, Any] = {}


class _Manifest(msgspec.Struct, kw_only=True):
    version: str
    suite: _SuiteFacts
    scenes_sha256: str | None = None
    began: str | None = None


def all_trials(scenes: Iterable[str], vehicles: Iterable[str], count: int) -> list[Trial]:
    """Return the trials of every scene with every vehicle, scene by scene.

    Args:
        scenes: Names of scenes.
        vehicles: Names of vehicles.
        count: Number of trials of each pair, numbered from 0.
    """
    vehicles = tuple(vehicles)
    return [
        Trial(scene, vehicle, number)
        for scene in scenes
        for vehicle in vehicles
        for number in range(count)
    ]


class Campaign:
    """Trials of a suite in a folder, see `open_campaign`."""

    def __init__(self, folder: Path, store: Store) -> None:
        self._folder = folder
        self._store = store

    def remaining(self, trials: Iterable[Trial]) -> list[Trial]:
        """Return the trials among some that are not in the folder yet."""
        return [trial for trial in trials if trial.id not in self._store.done]

    def fly(
        self, trials: Sequence[Trial], engine: Engine, *, workers: int, patience_s: float
    ) -> Generator[Row, None, None]:
        """Fly trials, and keep each row as its trial ends.

        Args:
            trials: Trials that are not in the folder yet.
            engine: Source of the processes that fly them, for the suite of the campaign.
            workers: Number of processes.
            patience_s: Wall time for one trial, after which its process is ended.

        Raises:
            WorkerError: If no trial can be flown.
            OSError: If a row cannot be written.
        """
        with Crew(engine, workers, patience_s) as crew:
            for row in crew.fly(trials):
                # Kept before it is yielded: a caller that stops loses nothing.
                self._store.add(row)
                yield row

    def summary(self) -> dict[str, Any]:
        """Return the summary of all trials in the folder, and write it there."""
        found = summarise_trials(read_results(self._folder, SUMMARY_COLUMNS))
        with replacing(self._folder / SUMMARY) as file:
            file.write(json.dumps(found, indent=2).encode() + b"\n")
        return found


@contextmanager
def open_campaign(folder: Path, suite: Suite) -> Iterator[Campaign]:
    """Open a campaign to fly on, or begin one.

    Args:
        folder: Folder of the results; created if it is missing.
        suite: Recipe and pilot.

    Raises:
        CampaignError: If the folder holds a campaign of another suite or version.
        StoreError: If another process flies in the folder.
        PilotError: If there is no such pilot.
        ProgramError: If there is no such program.
        FlightStackError: If there is no such flight stack.
        OSError: If the folder cannot be written to.
    """
    # Before anything is written.
    suite.require_pilot()
    _claim(folder, suite)
    with open_store(folder) as store:
        yield Campaign(folder, store)


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a folder: suite, version, digest of the scenes, day of the begin.

    Raises:
        CampaignError: If there is none, or it cannot be read.
    """
    path = folder / MANIFEST
    try:
        found = msgspec.json.decode(read_bounded(path, MOST_CONFIG_BYTES), type=_Manifest)
        return msgspec.to_builtins(found)
    except (OSError, ValueError, RecursionError) as error:
        raise _no_manifest(path, error) from None


def _no_manifest(path: Path, error: Exception) -> CampaignError:
    return CampaignError(
        f"file {str(path)!r} is no campaign's: {' '.join(str(error).split())}; "
        "valid: what `aeroscene campaign` has written"
    )


def read_suite(folder: Path) -> Suite | None:
    """Return the suite of the campaign in a folder; None if it holds none.

    Raises:
        CampaignError: If its manifest cannot be read.
    """
    if not (path := folder / MANIFEST).exists():
        return None
    suite = read_manifest(folder)["suite"]
    try:
        return Suite(
            recipe=recipe_from(suite["recipe"]),
            families={name: recipe_from(each) for name, each in suite["families"].items()},
            pilot=suite["pilot"],
            program=suite["program"],
            chat=chat_from(suite),
            stack=stack_from(suite),
            equipment=equipment_from(suite),
        )
    except ValueError as error:
        raise _no_manifest(path, error) from None


def chat_from(suite: dict[str, Any]) -> ChatModel | None:
    """Return the model that steers the pilot of a manifest; None if there is none."""
    endpoint, model = suite["endpoint"], suite["model"]
    return None if endpoint is None else ChatModel(endpoint=endpoint, model=model or "default")


def row_of(folder: Path, trial: Trial) -> Row | None:
    """Return the row of a trial in the results of a folder; None if it is not there."""
    if not (folder / JOURNAL).is_file():
        return None
    rows = read_results(folder, where=pc.field("trial_id") == trial.id).to_pylist()
    return rows[0] if rows else None


def _claim(folder: Path, suite: Suite) -> None:
    """Write the manifest, or refuse a folder of another campaign.

    Raises:
        CampaignError: If it holds a campaign of another suite or version.
    """
    if read_suite(folder) is None:
        folder.mkdir(parents=True, exist_ok=True)
        began = datetime.now(UTC).date().isoformat()
        with replacing(folder / MANIFEST) as file:
            file.write(json.dumps({"began": began, **_manifest(suite)}, indent=2).encode() + b"\n")
    else:
        require_same_suite(folder, suite)


def require_same_suite(folder: Path, suite: Suite) -> None:
    """Refuse a folder that holds a campaign of another suite; an empty one passes.

    Raises:
        CampaignError: If it holds a campaign of another suite or version.
    """
    if read_suite(folder) is None:
        return
    # Campaigns of earlier versions name no equipment, and had the usual one.
    usual = {"suite": {"equipment": json.loads(json.dumps(Equipment().to_plain()))}}
    present = _flat(usual) | _flat(read_manifest(folder))
    # Through JSON, which knows no tuples.
    for path, value in _flat(json.loads(json.dumps(_manifest(suite)))).items():
        if present.get(path) != value:
            raise CampaignError(
                f"out {str(folder)!r} holds a campaign with {path[-1]} {present.get(path)!r} "
                f"instead of {value!r}; valid: another folder, or the same options"
            )


def _manifest(suite: Suite) -> dict[str, Any]:
    return {
        "version": __version__,
        "scenes_sha256": shipped_digest(),
        "suite": suite.to_plain(),
    }


def _flat(plain: dict[str, Any], above: tuple[str, ...] = ()) -> dict[tuple[str, ...], Any]:
    """Return the values by their paths: recipes and equipment share some names."""
    found: dict[tuple[str, ...], Any] = {}
    for name, value in plain.items():
        path = (*above, name)
        found |= _flat(value, path) if isinstance(value, dict) else {path: value}
    return found
