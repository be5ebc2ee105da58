"""Records a flight until killed; prints each simulated second that it has handed over."""

import sys
from pathlib import Path

from aeroscene.solids.shapes import scene_primitives
from aeroscene.sources import load_scene
from flightsim.cameras import open_camera_renderer
from flightsim.testbench import Testbench, TestbenchCfg
from scenarios.recording import Recorder, RunInfo

with Testbench(load_scene("42"), TestbenchCfg(speed=4.0), has_network=False) as bench:
    recorder = Recorder(
        Path(sys.argv[1]),
        scene=bench.scene,
        primitives=scene_primitives(bench.scene),
        airframe=bench.airframe,
        info=RunInfo(scene="42", vehicle="iris", seed=0),
    )
    renderer = open_camera_renderer(bench.plant.world, 64, 48)

    def observe() -> None:
        recorder.on_tick(bench.plant, bench.autopilot)
        if bench.plant.time_us % 200_000 == 0:
            recorder.first.log_frame(renderer.render(bench.plant.data, "down", bench.plant.time_us))
        if bench.plant.time_us % 1_000_000 == 0:
            print(bench.plant.time_us // 1_000_000, flush=True)  # noqa: T201 - read by the test

    while True:
        bench.simulator.run(until_us=bench.plant.time_us + 20_000)
        observe()
