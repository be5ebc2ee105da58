"""`aeroscene-sitl`, also `aeroscene sitl`: the testbench, from the command line to its end."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from flightsim.testbench import TestbenchCfg, TestbenchError
from scenarios.cli.command_line import (
    EXIT_BAD_INPUT,
    EXIT_DONE,
    EXIT_NEGATIVE,
    execute,
    handling_signals,
    interrupt,
    interrupt_is_answered,
    print_json,
    raise_if_interrupted,
)
from scenarios.cli.entry import lasting
from scenarios.cli.repeated_options import gathered
from scenarios.cli.sitl_words import announce, print_results
from scenarios.cli.status_line import StatusLine
from scenarios.cli.terminal import Terminal, terminal
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl

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
    # Without a text of its own here, tyro would look for one in the sources, at every launch.
    bench: Annotated[TestbenchCfg, tyro.conf.arg(help="Settings of a simulation.")] = field(
        default_factory=TestbenchCfg
    )
    scene: Annotated[str, tyro.conf.arg(help_behavior_hint="(default: 42)")] = ""
    """Scene of the dataset by number, corpus:N, gen:SEED, district:SEED, field (open, flat), a
    scene file (.json, .json.gz), one of a file of layouts (FILE.jsonl#ID or #N), or a place on a
    map (FILE.osm#W,S,E,N in degrees, also .osm.gz, .osm.pbf and .geojson)."""
    bounds: Annotated[str, tyro.conf.arg(metavar="W,S,E,N", help_behavior_hint="")] = ""
    """Part of a map to fly in: west, south, east and north in degrees, up to 400 x 400 m. By
    default, all of a small map."""

    def __post_init__(self) -> None:
        """Refuse invalid options, two scenes, and bounds of a scene that is no map."""
        SitlCfg.__post_init__(self)
        if self.bounds:
            _require_map(self.place or self.scene, self.bounds)
        if self.place and self.scene:
            raise TestbenchError(
                f"scene {self.scene!r} is a second one beside {self.place!r}; valid: one"
            )

    @property
    def cfg(self) -> SitlCfg:
        """Configuration of the run, with the scene that either of the two options names."""
        values: dict[str, Any] = {name.name: getattr(self, name.name) for name in fields(SitlCfg)}
        scene = str(self.place or self.scene or SitlCfg.scene)
        values["scene"] = f"{scene}#{self.bounds}" if self.bounds else scene
        return SitlCfg(**values)


def _require_map(scene: str, bounds: str) -> None:
    """Refuse bounds of a scene that is no map, and malformed bounds."""
    from aeroscene.maps.bounds import parse_bounds
    from aeroscene.sources import is_map

    if not is_map(scene) or "#" in scene:
        raise TestbenchError(
            f"bounds {bounds!r} are those of no map, scene is {scene!r}; valid: with a map such as "
            "map.osm, map.osm.pbf or map.geojson"
        )
    parse_bounds(bounds)


def main(args: list[str] | None = None) -> int:
    """Run `aeroscene-sitl`.

    Args:
        args: Words of the command line; None takes those of the process.

    Returns:
        The exit status.
    """
    return execute(SitlCommand, run, PROG, gathered(sys.argv[1:] if args is None else args))


def run(command: SitlCommand) -> int:
    """Run the testbench until it is done or a signal stops it, and print the verdict.

    Returns:
        0, 1 if a pilot flew and failed, or 2 if the recording could not be written.

    Raises:
        INPUT_ERRORS: If the input is bad, or the machine lacks what the run needs.
    """
    # Standard output belongs to the result, so that `--json` can be piped.
    console = terminal(stderr=True)
    # SIGTERM must close ports, viewers and the recording too.
    signal.signal(signal.SIGTERM, interrupt)
    cfg = command.cfg
    _refuse_output_over_output(cfg)
    # Before the run, which makes the folders: afterwards nobody could tell.
    made = [path for path in _folders(cfg) if not path.exists()]
    with lasting():
        opened = Sitl(cfg)
    with opened as sitl:
        # Opening imports and compiles, where a Ctrl-C may have been swallowed.
        raise_if_interrupted()
        with _stop_on_signals() as should_stop, contextlib.ExitStack() as stack:
            announce(console, sitl)
            for folder in made:
                console.print(f"Folder {folder} was missing and is made.", soft_wrap=True)
            lines = [StatusLine(console, flight) for flight in sitl.flights]
            for line in lines:
                stack.enter_context(line)
            # `_refresh` returns None, so the lambda's value is the name of the signal, if any.
            sitl.run(lambda: _refresh(lines) or should_stop())
        result = sitl.result
        assert result is not None
        if command.json:
            print_json(result.to_plain())
        else:
            print_results(terminal(), result)
            for picture in sitl.pictures:
                print(f"Picture: {picture}")
        if sitl.viewer is not None and not should_stop():
            _keep_open(console, sitl.viewer)
        external = sitl.bench.external
    # After the verdict and the summary, which a flight stack that died may still allow.
    if external is not None and external.fault:
        raise TestbenchError(f"the run was ended by {external.fault}")
    if sitl.missing:
        return EXIT_BAD_INPUT  # The disk failed, not the vehicle.
    return EXIT_NEGATIVE if result.success is False else EXIT_DONE


def _refresh(lines: Sequence[StatusLine]) -> None:
    for line in lines:
        line.refresh()


def _refuse_output_over_output(cfg: SitlCfg) -> None:
    """Refuse a recording whose files would replace the file that standard output goes to."""
    if cfg.record is None:
        return
    for path in (cfg.record, cfg.record.with_suffix(".json")):
        is_same = False
        # The path may not exist yet, and standard output may be a pipe or an object of a test.
        with contextlib.suppress(OSError, ValueError):
            is_same = os.path.samestat(path.stat(), os.fstat(sys.stdout.fileno()))
        if is_same:
            raise TestbenchError(
                f"record {str(cfg.record)!r} writes {str(path)!r}, where standard output goes; "
                "valid: another name for one of them"
            )


def _folders(cfg: SitlCfg) -> list[Path]:
    """Return the folders that the run writes to."""
    folders = (cfg.record and cfg.record.parent, cfg.pictures, cfg.captures)
    return [folder for folder in folders if folder is not None]


def _keep_open(console: Terminal, viewer: Viewer) -> None:
    """Keep the viewer open until the user closes it or presses Ctrl-C."""
    page = "window" if viewer.url is None else "page"
    try:
        console.print(f"The flight has ended. The {page} stays until it is closed, or Ctrl-C.")
        viewer.wait()
    except KeyboardInterrupt:
        interrupt_is_answered()


@contextlib.contextmanager
def _stop_on_signals() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the name of the signal that asked for the end, or "".

    The first Ctrl-C or SIGTERM lets the run end in order: the recording is closed and the verdict
    printed. A second one interrupts at once.
    """
    requested: list[str] = []

    def request(number: int, _: FrameType | None) -> None:
        if requested:
            raise KeyboardInterrupt
        requested.append(signal.Signals(number).name)

    with handling_signals(request):
        yield lambda: requested[0] if requested else ""


if __name__ == "__main__":
    sys.exit(main())
