"""The lines that `aeroscene sitl` prints before and after a run."""

from __future__ import annotations

from collections.abc import Iterator

from flightsim.mavlink.links import is_loopback, local_ports
from scenarios.cli.terminal import Terminal, shell, styled
from scenarios.run.results import RunResult
from scenarios.run.sitl import Sitl
from scenarios.trials.result import TrialResult


def announce(console: Terminal, sitl: Sitl) -> None:
    """Print the scene, the vehicles, and the addresses at which clients connect.

    Args:
        console: Terminal to print on.
        sitl: The run, which has opened its ports already.
    """
    first, *mates = sitl.bench.vehicles
    scene, cfg = sitl.bench.scene, sitl.cfg.bench
    console.print(
        styled(
            (f"Scene {scene.scene_id}", "bold"),
            f": {scene.domain}, {len(scene.objects)} objects, "
            f"{len(scene.landing_areas)} landing areas, {len(scene.perching_areas)} to perch on. ",
            (first.airframe.title, "bold"),
            f", system {1 + cfg.instance}, seed {cfg.seed}, speed {cfg.speed}.",
        ),
        soft_wrap=True,
    )
    if sitl.words is not None:
        console.print(styled(("Goal: ", "bold"), sitl.words.text), soft_wrap=True)
    external = first.external
    if external is not None and not cfg.autopilot_binary:
        console.print(
            f"Waiting for {external.kind.title}, with the physics at {external.address}. Start it "
            f"in a folder of its own:\n{external.start_line}",
            highlight=False,
            soft_wrap=True,
        )
    ports = local_ports(cfg.instance)
    clients = (
        f"UDP {14550 + cfg.instance} (ground stations, from {ports.ground_station}), "
        f"UDP {14540 + cfg.instance} (SDKs, from {ports.sdk}), TCP {cfg.bind}:{ports.tcp[0]}"
        f"{''.join(f', {out}' for out in cfg.out)}"
        f"{cfg.serial and f', serial {cfg.serial}'}{cfg.signing_key and ', signed'}"
    )
    if external is not None:
        clients = external.kind.clients(cfg.instance)
    console.print(f"MAVLink: {clients}. Ctrl-C ends.", soft_wrap=True)
    if external is None and not is_loopback(cfg.bind):
        console.print(
            f"From another machine, with this one's address: UDP {ports.ground_station} (ground "
            f"stations), UDP {ports.sdk} (SDKs), TCP {', '.join(map(str, ports.tcp))}; "
            "MAVLink is not encrypted.",
            soft_wrap=True,
        )
    if external is None and (video := first.own.payload.video) is not None:
        console.print(f"Video: H.264 by RTP to {video.uri}", soft_wrap=True)
    if sitl.airsim_port is not None:
        console.print(f"AirSim: 127.0.0.1:{sitl.airsim_port}", soft_wrap=True)
    for number, mate in enumerate(mates, 2):
        east, north, _ = mate.plant.truth.position_enu_m
        console.print(
            styled(
                f"Vehicle {number}: ",
                (mate.airframe.title, "bold"),
                f", system {1 + mate.cfg.instance}, "
                f"at {east:.1f}, {north:.1f} m: UDP {14550 + cfg.instance}, "
                f"UDP {14540 + mate.cfg.instance}, TCP {5760 + 10 * mate.cfg.instance}.",
            ),
            soft_wrap=True,
        )
    if sitl.viewer is not None and sitl.viewer.url is not None:
        console.print(f"Watch at {sitl.viewer.url}", soft_wrap=True)


def print_results(console: Terminal, result: RunResult) -> None:
    """Print the verdict and the figures of each vehicle.

    Args:
        console: Terminal to print on.
        result: Result of the run; a figure that it lacks gets no line.
    """
    for number, each in enumerate(result.vehicles, 1):
        if len(result.vehicles) > 1:
            console.print(styled((f"Vehicle {number}", "bold"), f", {each.vehicle}"))
        _print_result(console, each)


def _print_result(console: Terminal, result: TrialResult) -> None:
    if result.success is not None:
        word = ("Done", "bold green")
        if not result.success:
            word = (f"Failed, {result.code}", "bold red")
        console.print(styled(word, f": {result.reason}"))
        # The width aligns these figures with the lines below, whose names are written out.
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
    if (exchanges := result.lockstep) is not None:
        console.print(
            "  lockstep                      "
            + ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in exchanges.items())
        )
    if result.recording is not None:
        console.print(f"  recording                     {result.recording}")
        replay = shell("aeroscene", "replay", result.recording)
        console.print(f"Replay it with: {replay}", soft_wrap=True)


def _figures(result: TrialResult) -> Iterator[tuple[str, float | int | str | None, str]]:
    """Yield name, value and unit of each figure on which the verdict rests."""
    # None stands for what the flight did not get to, such as a touchdown.
    yield "the vehicle is", result.fate and result.fate.replace("_", " "), ""
    yield "area, assigned", result.area, ""
    yield "area, landed on", result.landed_area, ""
    yield "distance from the goal", result.navigation_error_m, " m"
    yield "contacts before touchdown", result.contacts_before_touchdown, ""
    yield "touchdown error", result.touchdown_error_m, " m"
    yield "touchdown speed", result.touchdown_speed_mps, " m/s"
    yield "slide after touchdown", result.slide_m, " m"
    yield "rotors still after", result.stopped_after_s, " s"
    yield "least clearance", result.least_clearance_m, " m"
    yield "nearest mover", result.nearest_mover_m, " m"
