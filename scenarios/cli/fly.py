"""`aeroscene fly`: one trial of a campaign, with a recording."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from aeroscene.ranges import Range
from scenarios.campaigns.equipment import CameraHz, Equipment
from scenarios.campaigns.recordings import MANIFEST, RECORDINGS, Recordings
from scenarios.cli.campaign import chat_model
from scenarios.cli.campaign_limits import MOST_TRIALS
from scenarios.cli.command_line import (
    EXIT_BAD_INPUT,
    EXIT_DONE,
    EXIT_NEGATIVE,
    default_hint,
    fail,
    print_json,
)
from scenarios.cli.outputs import OutFolder
from scenarios.cli.terminal import shell, styled, terminal
from scenarios.run.levels import RecordLevel

if TYPE_CHECKING:
    from scenarios.campaigns.flyer import Row, Suite

_PROG = "aeroscene fly"
_OUTCOME = ("success", "code", "state_hash")
"""Columns by which two flights of a trial are compared."""


@dataclass(frozen=True, kw_only=True)
class FlyCfg:
    """Fly one trial and record it: the same flight as in the campaign, bit for bit.

    The recording is OUT/recordings/SCENE-VEHICLE-TRIAL.rrd; exit status 1 if the trial failed.
    """

    out: Annotated[Path, OutFolder()]
    """Folder of a campaign, whose recipe and pilot are used, or any other folder."""
    trial: Annotated[int, Range(0, MOST_TRIALS - 1)]
    """Number of the trial among those of the scene and the vehicle."""
    scene: str = "42"
    """Scene as the campaign names it, by its number."""
    vehicle: str = "iris"
    """Airframe by its name, or a file FILE.toml as the campaign names it."""
    pilot: Annotated[str | None, default_hint("the campaign's, else demo")] = None
    """Pilot, see `aeroscene campaign`. A class, a policy or a program that only the folder names is
    not run: name it again, or pass --trust."""
    program: Annotated[str | None, default_hint("none")] = None
    """With a campaign of --pilot mavlink: the command that flies, as the campaign names it."""
    endpoint: Annotated[str | None, default_hint("none")] = None
    """With --pilot vlm, or a campaign of it: address of the model, as the campaign names it."""
    model: str = "default"
    """With --endpoint: name of the model there."""
    autopilot_binary: Annotated[str | None, default_hint("none")] = None
    """With a campaign of --autopilot: the program of the flight stack, as the campaign has it."""
    trust: bool = False
    """Run what the folder's campaign.json names without naming it again."""
    recipe: Annotated[str | None, default_hint("the campaign's")] = None
    """Recipe from which the task is drawn: a TOML file, or a family by its name, such as crowd."""
    family: Annotated[str, default_hint("none")] = ""
    """With a campaign of a suite of families: the family of the trial."""
    record: RecordLevel = "full"
    """Level of detail of the recording, see docs/recording.md; the flight is the same."""
    camera_hz: CameraHz = 5.0
    """Frames of each camera in a simulated second of the recording."""
    # Without a text of its own here, tyro would look for one in the sources.
    equipment: Annotated[
        Equipment, tyro.conf.arg(help="Cameras and sensors; the campaign's by default.")
    ] = field(default_factory=Equipment)
    json: Annotated[bool, tyro.conf.arg(name="json")] = False
    """Print one JSON object: the row of the trial without its tracks, and same_as_campaign, which
    is null if the campaign has not flown it."""


def run(cfg: FlyCfg) -> int:
    """Fly the trial, record it, and compare it with the campaign's own flight.

    Returns:
        0, 1 if the trial failed, or 2 if the recording could not be written. A trial that does not
        exist ends the process with status 2 and one line.
    """
    # Imported here because it is the whole simulator, which `--help` does not need.
    from aeroscene.sources import canonical_name
    from flightsim.vehicles import airframe_by_name
    from scenarios.baselines.named import PilotError
    from scenarios.campaigns.campaign import CampaignError, row_of
    from scenarios.campaigns.external.program import ProgramError
    from scenarios.campaigns.flight_stack import FlightStackError
    from scenarios.campaigns.flyer import Flyer, Trial
    from scenarios.campaigns.store import TRACKS, StoreError

    airframe_by_name(cfg.vehicle)
    trial = Trial(canonical_name(cfg.scene), cfg.vehicle, cfg.trial, cfg.family)
    # A campaign shows one line for an exception of the pilot. Here it is shown with its traceback.
    logging.getLogger("scenarios.campaigns").setLevel(logging.INFO)
    try:
        suite, is_campaigns = _suite(cfg)
        _require_trust(cfg, suite)
        suite.require_pilot()
        # With another pilot or recipe than the campaign's, the flights need not be the same.
        before = row_of(cfg.out, trial) if is_campaigns else None
        suite.equipment.require(cfg.vehicle)
        folder = cfg.out / RECORDINGS
        recordings = Recordings(folder=folder, level=cfg.record, camera_hz=cfg.camera_hz)
        with Flyer(replace(suite, recordings=recordings), shows_program=True) as flyer:
            row = flyer.fly(trial)
    except (CampaignError, StoreError, PilotError, ProgramError, FlightStackError) as error:
        fail(_PROG, str(error))
    is_same = None if before is None else all(before[name] == row.get(name) for name in _OUTCOME)
    if cfg.json:
        facts = {name: value for name, value in row.items() if name not in TRACKS}
        print_json({**facts, "same_as_campaign": is_same})
    else:
        _print_row(row, is_same)
    if "recording" in row and row["recording"] is None:
        return EXIT_BAD_INPUT  # Not the vehicle failed but the disk.
    return EXIT_NEGATIVE if row["success"] is False else EXIT_DONE


def _suite(cfg: FlyCfg) -> tuple[Suite, bool]:
    """Return the suite of the trial, and whether it equals that of the campaign in the folder."""
    from scenarios.campaigns.campaign import read_suite
    from scenarios.campaigns.fixed import named_recipe
    from scenarios.campaigns.flyer import Suite

    campaigns = read_suite(cfg.out)
    suite = campaigns or Suite()
    if cfg.recipe is not None:
        suite = replace(suite, recipe=named_recipe(cfg.recipe))
    if cfg.pilot is not None:
        suite = replace(suite, pilot=cfg.pilot)
    if cfg.endpoint is not None:
        suite = replace(suite, chat=chat_model(_PROG, cfg.endpoint, cfg.model))
    if cfg.equipment != Equipment():
        suite = replace(suite, equipment=cfg.equipment)
    if cfg.program is not None:
        if not suite.is_external:
            fail(_PROG, f"program {cfg.program!r} needs --pilot mavlink; pilot is {suite.pilot!r}")
        suite = replace(suite, program=cfg.program)
    if (binary := cfg.autopilot_binary) is not None:
        if suite.stack is None:
            fail(_PROG, f"autopilot-binary {binary!r} needs a folder of a campaign of --autopilot")
        suite = replace(suite, stack=replace(suite.stack, binary=binary))
    return suite, suite == campaigns


def _require_trust(cfg: FlyCfg, suite: Suite) -> None:
    """Refuse code that only the folder names.

    The folder may come from somebody else, and the code would run with the user's rights.
    """
    named = {
        "pilot": cfg.pilot,
        "program": cfg.program,
        "endpoint": cfg.endpoint,
        "autopilot-binary": cfg.autopilot_binary,
    }
    for option, value in suite.foreign_code.items():
        if named[option] is None and not cfg.trust:
            fail(
                _PROG,
                f"{str(cfg.out / MANIFEST)!r} names the {option} {value!r}, which is not run just "
                f"because it stands there; valid: --{option} {shell(value)}, or --trust for "
                "all that the folder names",
            )


def _print_row(row: Row, is_same: bool | None) -> None:
    """Print the verdict, the task and where the recording is."""
    success = row["success"]
    word = "No task" if success is None else "Done" if success else f"Failed, {row['code']}"
    console = terminal()
    said = styled((row["trial_id"], "bold"), f" {word}: {row['reason']}")
    console.print(said, soft_wrap=True)
    if "way_m" in row:
        console.print(
            f"  from {row['start']} to area {row['area']}: {row['way_m']:.0f} m, "
            f"{row['difficulty']}, wind {row['wind_mps']:.1f} m/s",
            soft_wrap=True,
        )
    if row.get("text") is not None:
        console.print(styled(("  goal: ", "bold"), row["text"]), soft_wrap=True)
    if is_same is not None:
        console.print(f"  {'the same' if is_same else 'ANOTHER'} flight as in the campaign")
    if row.get("recording"):
        replay = shell("aeroscene", "replay", row["recording"])
        console.print(f"Replay it with: {replay}", soft_wrap=True)
