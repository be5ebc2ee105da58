"""The flight itself: kernels, a take-off in a scene, an image from the camera."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from scenarios.doctor.check import Check

if TYPE_CHECKING:
    from flightsim.testbench import Testbench

_SCENE, _VEHICLE = "42", "iris"
_READY_S, _CLIMB_S = 30.0, 10.0
"""Simulated seconds that the estimator may take to settle, and that the take-off may take."""
_LEAST_CLIMB_M = 1.0
_STEP_US = 500_000
_WIDTH_PX, _HEIGHT_PX = 320, 240
_SMOOTH_FRAME_MS = 50.0
"""Longer frames hold up a flight with two cameras at 5 Hz at real time."""
_N_FRAMES = 3


def check_kernels() -> Iterator[Check]:
    """Whether the flight kernels are compiled; the flight check compiles them if they are not."""
    from autonomy.jit import cache_directory  # noqa: PLC0415 - numba takes a quarter of a second

    is_warm = any(cache_directory("flightsim.plant.kernel").glob("*.compiled"))
    yield Check(
        name="flight kernels",
        status="ok",
        value="compiled" if is_warm else "were not compiled yet; this check did it, once",
    )


def check_flight() -> Iterator[Check]:
    """Take off for real, without network, and look through the cameras."""
    from aeroscene.sources import open_scene  # noqa: PLC0415 - the whole stack
    from flightsim.testbench import Testbench, TestbenchCfg  # noqa: PLC0415

    start_s = time.perf_counter()
    cfg = TestbenchCfg(vehicle=_VEHICLE, speed="max")
    with Testbench(open_scene(_SCENE), cfg, has_network=False) as bench:
        ready_s = time.perf_counter() - start_s
        yield Check(
            name="world",
            status="ok",
            value=f"scene {_SCENE} with {_VEHICLE} ready in {ready_s:.2f} s",
        )
        yield _take_off(bench)
        yield from _check_cameras(bench)


def _take_off(bench: Testbench) -> Check:
    """Arm and climb as a client would ask for it."""
    simulator, plant, autopilot = bench.simulator, bench.plant, bench.autopilot
    start_s = time.perf_counter()
    while not autopilot.prearm.is_ok and plant.time_us < _READY_S * 1e6:
        simulator.run(until_us=plant.time_us + _STEP_US)
    start_m = plant.truth.position_enu_m[2]
    takeoff, arm = autopilot.takeoff(), autopilot.arm()
    simulator.run(until_us=plant.time_us + round(_CLIMB_S * 1e6))
    factor = plant.time_us * 1e-6 / (time.perf_counter() - start_s)
    climb_m = plant.truth.position_enu_m[2] - start_m
    if climb_m < _LEAST_CLIMB_M:
        reasons = "; ".join((*autopilot.prearm.reasons, takeoff.reason, arm.reason)).strip("; ")
        return Check(
            name="take-off",
            status="problem",
            value=f"climbed {climb_m:.2f} m ({reasons})",
            remedy="please report it with this table",
        )
    return Check(
        name="take-off", status="ok", value=f"climbed {climb_m:.1f} m at {factor:.0f} x real time"
    )


def _check_cameras(bench: Testbench) -> Iterator[Check]:
    from flightsim.sensors.cameras import open_camera_renderer  # noqa: PLC0415

    renderer = open_camera_renderer(bench.world, _WIDTH_PX, _HEIGHT_PX)
    try:
        frame_ms: list[float] = []
        is_blank = False
        for _ in range(_N_FRAMES):
            start_s = time.perf_counter()
            frame = renderer.render(
                bench.plant.data, bench.airframe.cameras[0].name, bench.plant.time_us
            )
            frame_ms.append(1e3 * (time.perf_counter() - start_s))
            is_blank = bool(frame.rgb.max() == frame.rgb.min())
    finally:
        renderer.close()
    yield Check(
        name="renderer",
        status="problem" if is_blank else "ok",
        value=f"{renderer.backend} ({renderer.reason})",
        remedy="its image is blank: update the graphics driver" if is_blank else "",
    )
    best_ms = min(frame_ms)
    yield Check(
        name="camera frame",
        status="ok" if best_ms <= _SMOOTH_FRAME_MS else "note",
        value=f"{best_ms:.1f} ms for {_WIDTH_PX} x {_HEIGHT_PX} with depth",
        remedy="" if best_ms <= _SMOOTH_FRAME_MS else "record at a lower --camera-hz",
    )
