"""Draw scenes in several kinds of light and weather, side by side, as docs/light.md shows them.

python tools/draw_light.py
python tools/draw_light.py --scenes 42 45 --out sheet.jpg
"""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from PIL import Image, ImageDraw

from aeroscene.scene import Scene
from aeroscene.sources import load_scene
from flightsim.cameras import open_camera_renderer
from flightsim.looks.light import light_of
from flightsim.looks.weather import Season, parse_weather
from flightsim.world import build_world

LIGHTS: tuple[tuple[str, Season], ...] = (
    ("", "summer"),
    ("19:15, clear", "summer"),
    ("dusk, haze 900 m", "autumn"),
    ("night", "summer"),
    ("10:00, fog 70 m", "autumn"),
    ("rain", "spring"),
    ("11:00, snow", "winter"),
)
WIDTH_PX, HEIGHT_PX = 320, 224
_CAPTION_PX = 18
_QUALITY = 85


@dataclass(frozen=True, kw_only=True)
class LightCfg:
    """Scenes to draw, and the picture to write."""

    scenes: tuple[str, ...] = ("42", "45", "57")
    """Scenes, a row each."""
    out: Path = Path("docs/images/light.jpg")
    """Picture to write; its folder must exist."""


def draw(scene: Scene, text: str, season: Season) -> np.ndarray:
    """View of a scene from a vehicle's height, across its longer side, with the words above it."""
    light = light_of(parse_weather(text, season), scene.latitude_deg, scene.longitude_deg)
    world = build_world(scene, light=light)
    low, high = np.array(scene.extent_min_enu_m), np.array(scene.extent_max_enu_m)
    middle, half = (low + high) / 2, (high - low) / 2
    eye = (middle[0] + 0.55 * half[0], middle[1] - 0.7 * half[1], 9.0)
    with closing(open_camera_renderer(world, WIDTH_PX, HEIGHT_PX)) as renderer:
        target = (float(middle[0]), float(middle[1]), 1.0)
        rgb = renderer.render_view(world.new_data(), eye, target, math.radians(60.0)).rgb
    caption = Image.new("RGB", (WIDTH_PX, _CAPTION_PX), "white")
    words = f"{text or 'by default'}, {season}"
    ImageDraw.Draw(caption).text((4, 3), words, fill="black")
    return np.vstack([np.array(caption), rgb])


def main(cfg: LightCfg) -> None:
    """Draw the sheet."""
    rows = []
    for name in cfg.scenes:
        scene = load_scene(name)
        rows.append(np.hstack([draw(scene, *light) for light in LIGHTS]))
    Image.fromarray(np.vstack(rows)).save(cfg.out, quality=_QUALITY)


if __name__ == "__main__":
    main(tyro.cli(LightCfg, description=__doc__))
