"""RGB-D images with labels on disk: a vehicle hovers, turns and looks, eight times.

Each image becomes NNN.png (RGB), NNN.npz (`depth_m`, `object_id`) and NNN.json: the camera, its
true pose, and category and box of every object in view. Ids below 0: -2 bare ground, -3 sky.

    python examples/rgbd_dataset.py [FOLDER]
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import flightsim
from aeroscene import ControlLevel, Plant, PlantCfg, Scene, Setpoint, load_scene


def write(stem: Path, scene: Scene, frame, object_id: np.ndarray) -> None:
    """One image in three files."""
    Image.fromarray(frame.rgb).save(stem.with_suffix(".png"))
    np.savez_compressed(stem.with_suffix(".npz"), depth_m=frame.depth_m, object_id=object_id)
    seen = [scene.object_by_id[i] for i in np.unique(object_id).tolist() if i >= 0]
    label = {
        "fx_fy_cx_cy": [frame.fx, frame.fy, frame.cx, frame.cy],
        "position_enu_m": frame.position_enu_m,
        "rotation_enu_from_optical": frame.rotation_enu_from_optical.tolist(),
        "objects": {
            o.id: {"category": o.category, "p": o.bbox.p, "q": o.bbox.q, "s": o.bbox.s}
            for o in seen
        },
    }
    stem.with_suffix(".json").write_text(json.dumps(label), encoding="utf-8")


def main(folder: str = "rgbd") -> None:
    scene, out = load_scene("42"), Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    world = flightsim.build_world(scene, flightsim.airframe_by_name("iris"))
    plant = Plant(world, PlantCfg(seed=0))
    plant.align()
    x, y, z = plant.estimate.position_enu_m
    with flightsim.Cameras(plant, width_px=320, height_px=240) as cameras:
        for number in range(8):
            at, yaw_rad = (x, y, z + 5.0), number * math.pi / 4
            plant.apply(Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=at, yaw_rad=yaw_rad))
            for _ in range(200 if number else 400):
                plant.advance()
            frame, object_id = cameras.render("forward"), cameras.render_ids("forward")
            write(out / f"{number:03d}", scene, frame, object_id)
    print(f"8 images in {out}/")


if __name__ == "__main__":
    main(*sys.argv[1:])
