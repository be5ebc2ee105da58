"""Recording and display of a run while it goes on: a recording, a viewer, cameras.

rerun takes half a second to import, so only runs that are recorded or watched import this module.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

from aeroscene.solids.shapes import scene_primitives
from flightsim.cameras import Cameras, RgbdFrame
from flightsim.simulator import TICK_US
from flightsim.testbench import Testbench, TestbenchError, Vehicle
from flightsim.vehicles.builder import vehicle_name
from scenarios.recording import Recorder, RecordingError, RunInfo
from scenarios.recording.vehicle_recorder import VehicleRecorder
from scenarios.recording.viewer import DATA_PORT, Viewer, ViewerError, free_port
from scenarios.run.cfg import SitlCfg
from scenarios.run.flight import Flight
from scenarios.trials.figures import reached_s
from scenarios.trials.limits import LIMITS


def watch(
    cfg: SitlCfg, bench: Testbench, flights: Sequence[Flight], stack: ExitStack
) -> tuple[Recorder, Viewer | None]:
    """Record a run from now on, and show it live if that is asked for.

    Args:
        cfg: Configuration of the run.
        bench: Its testbench.
        flights: Flight of each vehicle.
        stack: Closes recorder and viewer.

    Raises:
        TestbenchError: If the file or the viewer cannot be opened.
    """
    # The recorder serves the viewer's data, so it is opened first.
    viewer = None
    try:
        recorder = stack.enter_context(_recorder(cfg, flights))
        if cfg.viewer != "off" and recorder.url is not None:
            viewer = stack.enter_context(Viewer(cfg.viewer, recorder.url))
    except (RecordingError, ViewerError) as error:
        raise TestbenchError(str(error)) from error
    parts = (recorder.first, *recorder.other_vehicles.values())
    for flight, part in zip(flights, parts, strict=True):
        _follow(cfg, bench, flight, part)
    return recorder, viewer


def _follow(cfg: SitlCfg, bench: Testbench, flight: Flight, recorder: VehicleRecorder) -> None:
    """Record a vehicle from now on, with its cameras and its pilot."""
    vehicle, plant = flight.vehicle, flight.vehicle.plant
    if cfg.camera_hz > 0 and cfg.record_level in {"interaction", "full"}:
        bench.observers.append(_watch_cameras(cfg, flight, recorder))
    if vehicle.lidar is not None and cfg.record_level == "full":
        vehicle.lidar.listeners.append(recorder.log_scan)
    if flight.pilot is not None:
        from scenarios.recording.pilot_log import PilotLog

        pilot_log = PilotLog(flight.pilot, recorder)
        bench.observers.append(lambda: pilot_log.on_tick(plant.time_us))
    vehicle.stack.listen(
        lambda severity, text: recorder.log_statustext(plant.time_us, severity, text)
    )
    bench.observers.append(lambda: recorder.on_tick(plant, vehicle.stack.reports))


def _watch_cameras(cfg: SitlCfg, flight: Flight, recorder: VehicleRecorder) -> Callable[[], None]:
    """Return an observer that records the cameras: all the time, or only depth from the area on."""
    look = shutter(flight.vehicle, flight.cameras, cfg.camera_hz)
    if cfg.record_level == "full":
        flight.cameras.listen(recorder.log_frame)
        return look
    plant, is_there = flight.vehicle.plant, False

    def look_when_there() -> None:
        nonlocal is_there
        area = flight.companion.area if flight.companion is not None else None
        # Once above the area, the images go on, even if the vehicle leaves it again.
        is_there = is_there or reached_s(plant.history, flight.area or area) is not None
        if is_there:
            look()

    def keep(frame: RgbdFrame) -> None:
        if is_there:
            recorder.log_frame(frame, has_colour=False)

    flight.cameras.listen(keep)
    return look_when_there


def _recorder(cfg: SitlCfg, flights: Sequence[Flight]) -> Recorder:
    first, pilot = flights[0].vehicle, flights[0].pilot
    return Recorder(
        cfg.record,
        scene=first.scene,
        primitives=scene_primitives(first.scene),
        airframe=first.airframe,
        info=RunInfo(
            scene=first.scene.scene_id,
            vehicle=first.airframe.name,
            seed=cfg.bench.seed,
            config=cfg.to_plain(),
            limits=LIMITS.to_plain(),
        ),
        goal_enu_m=None if pilot is None else pilot.area.centroid,
        serve_port=None if cfg.viewer == "off" else free_port(DATA_PORT),
        is_summary=cfg.record_level == "summary",
        has_segments=cfg.bench.segmentation,
        other_vehicles={
            vehicle_name(number): flight.vehicle.airframe
            for number, flight in enumerate(flights)
            if number > 0
        },
    )


def shutter(vehicle: Vehicle, cameras: Cameras, rate_hz: float) -> Callable[[], None]:
    """Return an observer that renders every camera at a rate; call it after each tick."""
    names = [mount.name for mount in vehicle.airframe.rgbd_cameras]
    period_us = round(1e6 / rate_hz)

    def on_tick() -> None:
        # True for one tick in each period, whatever the rate.
        if vehicle.plant.time_us % period_us < TICK_US:
            for name in names:
                cameras.render(name)

    return on_tick
