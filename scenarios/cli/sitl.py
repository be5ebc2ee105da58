"""`aeroscene-sitl`, also `aeroscene sitl`: start the testbench."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import tyro
from rich.console import Console

from flightsim.testbench import TestbenchError
from scenarios.cli.command_line import (
    EXIT_BAD_INPUT,
    EXIT_DONE,
    EXIT_NEGATIVE,
    execute,
    handling_signals,
    print_json,
)
from scenarios.cli.status_line import StatusLine
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from scenarios.trials.result import TrialResult

if TYPE_CHECKING:
    from scenarios.recording.viewer import Viewer

PROG = "aeroscene-sitl"


@dataclass(frozen=True, kw_only=True)
class SitlCommand(SitlCfg):
    """Start the testbench: a scene, a quadrotor in it, an autopilot that speaks MAVLink.

    Ground stations connect at UDP 14550, SDKs at UDP 14540 (udpin://0.0.0.0:14540), scripts also at
    TCP 5760. Ctrl-C ends the run and closes the recording.
    """

    place: tyro.conf.Positional[
        Annotated[str, tyro.conf.arg(metavar="[SCENE]", help_behavior_hint="")]
    ] = ""
    """Scene to fly in; the same as --scene."""
    scene: Annotated[str, tyro.conf.arg(help_behavior_hint="(default: 42)")] = ""
    """Scene of the dataset by number, corpus:N, gen:SEED, field (open, flat), a scene file (.json,
    .json.gz), or one of a file of layouts (.jsonl, .jsonl.gz) as FILE#ID or FILE#N."""

    def __post_init__(self) -> None:
        """Refuse invalid options, and two scenes."""
        SitlCfg.__post_init__(self)
        if self.place and self.scene:
            raise TestbenchError(
                f"scene {self.scene!r} is a second one beside {self.place!r}; valid: one"
            )

    @property
    def cfg(self) -> SitlCfg:
        """Configuration of the run."""
        values: dict[str, Any] = {name.name: getattr(self, name.name) for name in fields(SitlCfg)}
        values["scene"] = str(self.place or self.scene or SitlCfg.scene)
        return SitlCfg(**values)


def main(args: list[str] | None = None) -> int:
    """Run `aeroscene-sitl`; returns the exit status."""
    return execute(SitlCommand, run, PROG, args)


def run(command: SitlCommand) -> int:
    """Run the testbench until it is done or told to stop.

    Raises:
        INPUT_ERRORS: If the input is bad, or the machine lacks what the run needs.
    """
    # Standard output belongs to the result.
    console = Console(stderr=True)
    # SIGTERM must close ports, viewers and the recording too.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    cfg = command.cfg
    _refuse_output_over_output(cfg)
    made = [path for path in _folders(cfg) if not path.exists()]
    with Sitl(cfg) as sitl:
        _announce(console, sitl)
        for folder in made:
            console.print(f"Folder {folder} was missing and is made.", soft_wrap=True)
        with _stop_on_signals() as should_stop, StatusLine(console, sitl) as status:
            result = sitl.run(lambda: status.refresh() or should_stop())
        if command.json:
            print_json(result.to_plain())
        else:
            _print_result(Console(), result)
            for picture in sitl.pictures:
                print(f"Picture: {picture}")
        if sitl.viewer is not None and not should_stop():
            _keep_open(console, sitl.viewer)
        external = sitl.bench.external
    if external is not None and external.fault:
        line = f"{PROG}: error: the run was ended by {external.fault}"
        console.print(line, markup=False, highlight=False, soft_wrap=True)
        return EXIT_BAD_INPUT
    if sitl.missing:
        return EXIT_BAD_INPUT  # Not the vehicle failed but the disk.
    return EXIT_NEGATIVE if result.success is False else EXIT_DONE


def _refuse_output_over_output(cfg: SitlCfg) -> None:
    """Refuse a recording whose files would take the place of the one that is standard output."""
    if cfg.record is None:
        return
    for path in (cfg.record, cfg.record.with_suffix(".json")):
        is_same = False
        # Neither may be there, and standard output may be none of the system's files.
        with contextlib.suppress(OSError, ValueError):
            is_same = os.path.samestat(path.stat(), os.fstat(sys.stdout.fileno()))
        if is_same:
            raise TestbenchError(
                f"record {str(cfg.record)!r} writes {str(path)!r}, where standard output goes; "
                "valid: another name for one of them"
            )


def _folders(cfg: SitlCfg) -> list[Path]:
    """Folders that the run writes to."""
    folders = (cfg.record and cfg.record.parent, cfg.pictures, cfg.captures)
    return [folder for folder in folders if folder is not None]


def _announce(console: Console, sitl: Sitl) -> None:
    scene, cfg = sitl.bench.scene, sitl.cfg.bench
    console.print(
        f"[bold]Scene {scene.scene_id}[/]: {scene.domain}, {len(scene.objects)} objects, "
        f"{len(scene.landing_areas)} landing areas, "
        f"{len(scene.perching_areas)} to perch on. [bold]{sitl.bench.airframe.title}[/], "
        f"system {1 + cfg.instance}, seed {cfg.seed}, speed {cfg.speed}.",
        soft_wrap=True,
    )
    external = sitl.bench.external
    if external is not None and not cfg.autopilot_binary:
        console.print(
            f"Waiting for {external.kind.title}, with the physics at {external.address}. Start it "
            f"in a folder of its own:\n{external.start_line}",
            highlight=False,
            soft_wrap=True,
        )
    clients = (
        f"UDP {14550 + cfg.instance} (ground stations), "
        f"UDP {14540 + cfg.instance} (SDKs), TCP {cfg.bind}:{5760 + 10 * cfg.instance}"
        f"{cfg.serial and f', serial {cfg.serial}'}{cfg.signing_key and ', signed'}"
    )
    if external is not None:
        clients = external.kind.clients(cfg.instance)
    console.print(f"MAVLink: {clients}. Ctrl-C ends.", soft_wrap=True)
    if external is None and (video := sitl.bench.payload.video) is not None:
        console.print(f"Video: H.264 by RTP to {video.uri}", soft_wrap=True)
    if sitl.viewer is not None and sitl.viewer.url is not None:
        console.print(f"Watch at {sitl.viewer.url}", soft_wrap=True)


def _print_result(console: Console, result: TrialResult) -> None:
    if result.success is not None:
        word = "[bold green]Done[/]" if result.success else f"[bold red]Failed, {result.code}[/]"
        console.print(f"{word}: {result.reason}")
        for name, figure, unit in _figures(result):
            if figure is not None:
                console.print(f"  {name:<29} {figure}{unit}")
    if result.position_rmse_m is not None:
        console.print(
            f"  estimate against truth, RMS   {result.position_rmse_m:.2f} m, "
            f"{result.attitude_rmse_deg:.2f} degrees"
        )
    console.print(
        f"  simulated                     {result.sim_seconds:.1f} s in "
        f"{result.wall_seconds:.1f} s: {result.real_time_factor:.1f} times real time"
    )
    if result.recording is not None:
        console.print(f"  recording                     {result.recording}")
        console.print(f"Replay it with: aeroscene replay {result.recording}", soft_wrap=True)


def _figures(result: TrialResult) -> Iterator[tuple[str, float | int | str | None, str]]:
    """Name, value and unit of what the verdict rests on."""
    yield "area, assigned", result.area, ""
    yield "area, landed on", result.landed_area, ""
    yield "contacts before touchdown", result.contacts_before_touchdown, ""
    yield "touchdown error", result.touchdown_error_m, " m"
    yield "touchdown speed", result.touchdown_speed_mps, " m/s"
    yield "slide after touchdown", result.slide_m, " m"
    yield "rotors still after", result.stopped_after_s, " s"
    yield "least clearance", result.least_clearance_m, " m"
    yield "nearest mover", result.nearest_mover_m, " m"


def _keep_open(console: Console, viewer: Viewer) -> None:
    """Keep the viewer open until the user closes it or presses Ctrl-C."""
    page = "window" if viewer.url is None else "page"
    with contextlib.suppress(KeyboardInterrupt):
        console.print(f"The flight has ended. The {page} stays until it is closed, or Ctrl-C.")
        viewer.wait()


@contextlib.contextmanager
def _stop_on_signals() -> Iterator[Callable[[], str]]:
    """Turn Ctrl-C and termination into a request by name; a second one interrupts at once."""
    requested: list[str] = []

    def request(number: int, _: FrameType | None) -> None:
        if requested:
            raise KeyboardInterrupt
        requested.append(signal.Signals(number).name)

    with handling_signals(request):
        yield lambda: requested[0] if requested else ""


if __name__ == "__main__":
    sys.exit(main())
