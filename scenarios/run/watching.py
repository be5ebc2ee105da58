"""What is kept and shown of a run while it goes on: a recording, a viewer, cameras.

rerun takes half a second to import: only runs that are recorded or watched import this module.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from aeroscene.solids.shapes import scene_primitives
from flightsim.cameras import Cameras, RgbdFrame
from flightsim.simulator import TICK_US
from flightsim.testbench import Testbench, TestbenchError
from flightsim.vehicles.builder import vehicle_name
from scenarios.recording import Recorder, RecordingError, RunInfo
from scenarios.recording.vehicle_recorder import VehicleRecorder
from scenarios.recording.viewer import DATA_PORT, Viewer, ViewerError, free_port
from scenarios.run.cfg import SitlCfg
from scenarios.trials.limits import LIMITS
from scenarios.trials.score import reached_s

if TYPE_CHECKING:
    from scenarios.pilot import Pilot
    from scenarios.run.sitl import Sitl


def watch(sitl: Sitl, stack: ExitStack) -> tuple[Recorder, Viewer | None]:
    """Record a run from now on, and show it live if that is asked for.

    Args:
        sitl: The run.
        stack: Closes recorder and viewer.

    Raises:
        TestbenchError: If the file or the viewer cannot be had.
    """
    bench, cfg = sitl.bench, sitl.cfg
    viewer = None
    try:
        recorder = stack.enter_context(_recorder(bench, cfg, sitl.pilot))
        if cfg.viewer != "off" and recorder.url is not None:
            viewer = stack.enter_context(Viewer(cfg.viewer, recorder.url))
    except (RecordingError, ViewerError) as error:
        raise TestbenchError(str(error)) from error
    follow(sitl, recorder.first)
    return recorder, viewer


def follow(sitl: Sitl, recorder: VehicleRecorder) -> None:
    """Record the vehicle of a run from now on, with its cameras and its pilot."""
    bench, cfg, pilot, plant = sitl.bench, sitl.cfg, sitl.pilot, sitl.bench.plant
    if cfg.camera_hz > 0 and cfg.record_level in {"interaction", "full"}:
        _watch_cameras(sitl, recorder)
    if bench.lidar is not None and cfg.record_level == "full":
        bench.lidar.listeners.append(recorder.log_scan)
    if pilot is not None:
        from scenarios.recording.pilot_log import PilotLog

        pilot_log = PilotLog(pilot, recorder)
        bench.observers.append(lambda: pilot_log.on_tick(plant.time_us))
    bench.stack.listen(
        lambda severity, text: recorder.log_statustext(plant.time_us, severity, text)
    )
    bench.observers.append(lambda: recorder.on_tick(plant, bench.stack.reports))


def _watch_cameras(sitl: Sitl, recorder: VehicleRecorder) -> None:
    """Record what the cameras see: all the way, or depth alone from the area on."""
    look = shutter(sitl.bench, sitl.cameras, sitl.cfg.camera_hz)
    if sitl.cfg.record_level == "full":
        sitl.cameras.listen(recorder.log_frame)
        sitl.bench.observers.append(look)
        return
    plant, is_there = sitl.bench.plant, False

    def look_when_there() -> None:
        nonlocal is_there
        area = sitl.companion.area if sitl.companion is not None else None
        is_there = is_there or reached_s(plant.history, sitl.area or area) is not None
        if is_there:
            look()

    def keep(frame: RgbdFrame) -> None:
        if is_there:
            recorder.log_frame(frame, has_colour=False)

    sitl.cameras.listen(keep)
    sitl.bench.observers.append(look_when_there)


def _recorder(bench: Testbench, cfg: SitlCfg, pilot: Pilot | None) -> Recorder:
    return Recorder(
        cfg.record,
        scene=bench.scene,
        primitives=scene_primitives(bench.scene),
        airframe=bench.airframe,
        info=RunInfo(
            scene=bench.scene.scene_id,
            vehicle=bench.airframe.name,
            seed=cfg.bench.seed,
            config=cfg.to_plain(),
            limits=LIMITS.to_plain(),
        ),
        goal_enu_m=None if pilot is None else pilot.area.centroid,
        serve_port=None if cfg.viewer == "off" else free_port(DATA_PORT),
        is_summary=cfg.record_level == "summary",
        has_segments=cfg.bench.segmentation,
        mates={
            vehicle_name(number): vehicle.airframe
            for number, vehicle in enumerate(bench.world.vehicles)
            if number > 0
        },
    )


def shutter(bench: Testbench, cameras: Cameras, rate_hz: float) -> Callable[[], None]:
    """Renders every camera of the vehicle at a rate; call it after each tick."""
    names = [mount.name for mount in bench.airframe.rgbd_cameras]
    period_us = round(1e6 / rate_hz)

    def on_tick() -> None:
        if bench.plant.time_us % period_us < TICK_US:
            for name in names:
                cameras.render(name)

    return on_tick
