"""Our pilot plans, flies, chooses its touchdown point from depth and lands; the run is recorded.

The same as `aeroscene sitl 42 --demo --record fly_demo.rrd`, as a value in Python.

    python examples/fly_demo.py [SCENE]
    aeroscene replay fly_demo.rrd
"""

import sys
from pathlib import Path

from aeroscene import Sitl, SitlCfg, TestbenchCfg, TrialResult


def main(scene: str = "42") -> TrialResult:
    """Fly a scene as fast as this machine can."""
    cfg = SitlCfg(
        scene=scene,
        demo=True,
        record=Path("fly_demo.rrd"),
        camera_hz=1.0,
        bench=TestbenchCfg(vehicle="iris", seed=0, speed="max"),
    )
    with Sitl(cfg, has_network=False) as sitl:
        result = sitl.run()
    print(f"{'landed' if result.success else 'failed'}: {result.reason}")
    print(f"{result.sim_seconds} s simulated in {result.wall_seconds} s, {result.recording}")
    return result


if __name__ == "__main__":
    main(*sys.argv[1:])
