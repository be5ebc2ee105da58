"""A scene that nobody has seen: the model makes it from a seed, then our pilot flies it.

Generating needs torch: pip install 'aeroscene[model]'. The same seed gives the same scene.

    python examples/generate_and_fly.py [SEED]
"""

import sys

from aeroscene import (
    SceneError,
    Sitl,
    SitlCfg,
    TestbenchCfg,
    TrialResult,
    generate_scene,
    write_scene,
)


def main(seed: int = 7) -> TrialResult:
    """Generate a scene, keep it, land in it."""
    scene = generate_scene(seed)
    path = f"{scene.scene_id}.json"
    write_scene(scene, path)
    areas = len(scene.landing_areas)
    print(f"{path}: {scene.domain}, {len(scene.objects)} objects, {areas} landing areas")
    cfg = SitlCfg(demo=True, bench=TestbenchCfg(speed="max"))
    with Sitl(cfg, scene=scene, has_network=False) as sitl:
        result = sitl.run()
    print(result.reason)
    return result


if __name__ == "__main__":
    try:
        main(*map(int, sys.argv[1:]))
    except SceneError as error:  # also: torch is missing
        sys.exit(str(error))
