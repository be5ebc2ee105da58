"""Checks of flight: compiled kernels, a take-off in a scene and a camera image."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from contextlib import closing
from typing import TYPE_CHECKING

from scenarios.doctor.check import Check, judged

if TYPE_CHECKING:
    from flightsim.testbench import Testbench

_SCENE, _VEHICLE = "42", "iris"
_READY_S, _CLIMB_S = 30.0, 10.0
"""Simulated seconds allowed for the estimator to settle and for the take-off."""
_LEAST_CLIMB_M = 1.0
_STEP_US = 500_000
_WIDTH_PX, _HEIGHT_PX = 320, 240
_SMOOTH_FRAME_MS = 50.0
"""Frame time beyond which two cameras at 5 Hz slow a flight below real time."""
_N_FRAMES = 3  # The first frame also loads what later ones reuse, so the best one counts.


def check_kernels() -> Iterator[Check]:
    """Report whether the flight kernels were compiled already; the flight check compiles them."""
    from autonomy.jit import cache_directory

    directory = cache_directory("flightsim.plant.kernel")
    is_readable = directory is not None and os.access(directory, os.R_OK | os.X_OK)
    is_warm = directory is not None and is_readable and any(directory.glob("*.compiled"))
    yield Check(
        name="flight kernels",
        status="ok",
        value="compiled" if is_warm else "were not compiled yet; this check did it, once",
    )


def check_flight() -> Iterator[Check]:
    """Take off for real, without network, and render camera images.

    Yields:
        Results for the world, the take-off, the renderer and the time of a frame.
    """
    from aeroscene.sources import load_scene
    from flightsim.testbench import Testbench, TestbenchCfg

    start_s = time.perf_counter()
    cfg = TestbenchCfg(vehicle=_VEHICLE, speed="max")
    with Testbench(load_scene(_SCENE), cfg, has_network=False) as bench:
        ready_s = time.perf_counter() - start_s
        value = f"scene {_SCENE} with {_VEHICLE} ready in {ready_s:.2f} s"
        yield Check(name="world", status="ok", value=value)
        yield _take_off(bench)
        yield from _check_cameras(bench)


def _take_off(bench: Testbench) -> Check:
    """Take off like a client: wait until ready, ask for a take-off, arm."""
    simulator, plant, autopilot = bench.simulator, bench.plant, bench.autopilot
    start_s = time.perf_counter()
    # If it never gets ready, arming below fails with the reasons that are shown.
    while not autopilot.prearm.is_ok and plant.time_us < _READY_S * 1e6:
        simulator.run(until_us=plant.time_us + _STEP_US)
    start_m = plant.truth.position_enu_m[2]
    takeoff, arm = autopilot.takeoff(), autopilot.arm()
    simulator.run(until_us=plant.time_us + round(_CLIMB_S * 1e6))
    factor = plant.time_us * 1e-6 / (time.perf_counter() - start_s)
    climb_m = plant.truth.position_enu_m[2] - start_m
    is_fine = climb_m >= _LEAST_CLIMB_M
    value = f"climbed {climb_m:.1f} m at {factor:.0f} x real time"
    if not is_fine:
        reasons = "; ".join((*autopilot.prearm.reasons, takeoff.reason, arm.reason)).strip("; ")
        value = f"climbed {climb_m:.2f} m ({reasons})"
    remedy = "please report it with this table"
    return judged("take-off", value, remedy, is_fine=is_fine, fault="problem")


def _check_cameras(bench: Testbench) -> Iterator[Check]:
    from flightsim.cameras import open_camera_renderer

    camera, best_ms, is_blank = bench.airframe.cameras[0].name, math.inf, False
    with closing(open_camera_renderer(bench.plant.world, _WIDTH_PX, _HEIGHT_PX)) as renderer:
        for _ in range(_N_FRAMES):
            start_s = time.perf_counter()
            frame = renderer.render(bench.plant.data, camera, bench.plant.time_us)
            best_ms = min(best_ms, 1e3 * (time.perf_counter() - start_s))
            # A renderer that does not work may return an image of one colour without any error.
            is_blank = bool(frame.rgb.max() == frame.rgb.min())
    backend = f"{renderer.backend} ({renderer.reason})"
    remedy = "its image is blank: update the graphics driver"
    yield judged("renderer", backend, remedy, is_fine=not is_blank, fault="problem")
    value = f"{best_ms:.1f} ms for {_WIDTH_PX} x {_HEIGHT_PX} with depth"
    is_smooth = best_ms <= _SMOOTH_FRAME_MS
    yield judged("camera frame", value, "record at a lower --camera-hz", is_fine=is_smooth)
