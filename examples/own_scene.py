"""A scene from twenty lines of Python: a meadow and a row of containers to land on.

The landing areas are derived from the geometry; the scene is checked, written as JSON, and flown.

    python examples/own_scene.py
"""

from dataclasses import replace

import aeroscene
from aeroscene import Sitl, SitlCfg, TestbenchCfg, TrialResult

NAME = "container-yard"


def put(number: int, category: str, centre_enu_m, size_m) -> aeroscene.SceneObject:
    """One object: an upright box by its centre and its size."""
    box = aeroscene.OrientedBox(p=centre_enu_m, q=(1.0, 0.0, 0.0, 0.0), s=size_m)
    kind = aeroscene.category_id(category)
    return aeroscene.SceneObject(
        id=number, scene_id=NAME, parent_id=None, category_id=kind, bbox=box, domain="outdoor"
    )


def container_yard() -> aeroscene.Scene:
    scene = aeroscene.Scene(
        scene_id=NAME,
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-20, -20, 0),
        extent_max_enu_m=(20, 20, 15),
        start_position_enu_m=(0, -12, 0.1),
        start_yaw_rad=1.57,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488,
        objects=(
            put(0, "lawn", (0, 0, 0.05), (40, 40, 0.1)),
            *(put(1 + i, "container", (6 * i, 12, 1.35), (2.4, 6, 2.5)) for i in range(3)),
        ),
    )
    return replace(scene, interaction_areas=aeroscene.derive_interaction_areas(scene))


def main() -> TrialResult:
    scene = container_yard()
    print(f"{len(scene.landing_areas)} landing areas; wrong with it: {aeroscene.validate(scene)}")
    aeroscene.write_scene(scene, f"{NAME}.json")  # also: aeroscene sitl container-yard.json
    cfg = SitlCfg(demo=True, bench=TestbenchCfg(speed="max"))
    with Sitl(cfg, scene=scene, has_network=False) as sitl:
        return sitl.run()


if __name__ == "__main__":
    print(main())
