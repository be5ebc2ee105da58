"""`aeroscene-sitl`: start the testbench."""

from __future__ import annotations

import json
import logging
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from rich.console import Console

from scenarios.cli.command_line import (
    EXIT_DONE,
    EXIT_INTERRUPTED,
    EXIT_NEGATIVE,
    fail,
    parse,
)
from scenarios.cli.status_line import StatusLine
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import INPUT_ERRORS, Sitl
from scenarios.run.trial import TrialResult

PROG = "aeroscene-sitl"


def main(args: list[str] | None = None) -> int:
    """Run the command; returns the exit status."""
    logging.basicConfig(level=logging.WARNING, format=f"{PROG}: %(message)s", stream=sys.stderr)
    try:
        return run(parse(SitlCfg, PROG, args))
    except INPUT_ERRORS as error:
        fail(PROG, str(error))
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED


def run(cfg: SitlCfg) -> int:
    """Run the testbench until it is done or told to stop.

    Raises:
        INPUT_ERRORS: If something cannot be had.
    """
    # Standard output belongs to the result.
    console = Console(stderr=True)
    with Sitl(cfg) as sitl:
        with _stop_on_signals() as should_stop, StatusLine(console, sitl) as status:
            _announce(console, sitl)
            result = sitl.run(lambda: status.refresh() or should_stop())
    if cfg.json:
        print(json.dumps(result.to_plain()))
    else:
        _print_result(Console(), result)
        for picture in sitl.pictures:
            print(f"Picture: {picture}")
    return EXIT_NEGATIVE if result.success is False else EXIT_DONE


def _announce(console: Console, sitl: Sitl) -> None:
    scene, cfg = sitl.bench.scene, sitl.cfg.bench
    console.print(
        f"[bold]Scene {scene.scene_id}[/]: {scene.domain}, {len(scene.objects)} objects, "
        f"{len(scene.landing_areas)} landing areas, "
        f"{len(scene.perching_areas)} to perch on. [bold]{sitl.bench.airframe.title}[/], "
        f"system {1 + cfg.instance}, seed {cfg.seed}, speed {cfg.speed}."
    )
    console.print(
        f"MAVLink: UDP {14550 + cfg.instance} (ground stations), "
        f"UDP {14540 + cfg.instance} (SDKs), TCP {cfg.bind}:{5760 + 10 * cfg.instance}. "
        "Ctrl-C ends."
    )
    if sitl.viewer_url is not None:
        console.print(f"Watch at {sitl.viewer_url}", soft_wrap=True)


def _print_result(console: Console, result: TrialResult) -> None:
    if result.success is not None:
        word = "[bold green]Landed[/]" if result.success else "[bold red]Failed[/]"
        console.print(f"{word}: {result.reason}")
        console.print(f"  landing area                  {result.area}")
        console.print(f"  contacts before touchdown     {result.contacts_before_touchdown}")
        if result.touchdown_error_m is not None:
            console.print(f"  touchdown error               {result.touchdown_error_m:.2f} m")
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


@contextmanager
def _stop_on_signals() -> Iterator[Callable[[], bool]]:
    """Turn Ctrl-C and termination into a request; a second Ctrl-C interrupts at once."""
    requested: list[int] = []

    def request(number: int, _: FrameType | None) -> None:
        if requested:
            raise KeyboardInterrupt
        requested.append(number)

    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, request) for number in numbers]
    try:
        yield lambda: bool(requested)
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


if __name__ == "__main__":
    sys.exit(main())
