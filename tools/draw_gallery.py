"""Draw the pictures of docs/gallery.md, all of them or some.

python tools/draw_gallery.py
python tools/draw_gallery.py --only categories --out /tmp/chart
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import tyro
from category_chart import category_chart
from PIL import Image

from flightsim.sensors.camera import Quality

_JPEG_QUALITY = 85

Section = Literal["categories"]


@dataclass(frozen=True, kw_only=True)
class GalleryCfg:
    """Draw the gallery."""

    out: Path = Path("docs/images/gallery")
    """Folder for the pictures."""
    only: tuple[Section, ...] = ()
    """Sections to draw; all of them when none is named."""
    quality: Quality = "fine"
    """"fast" draws a draft in seconds."""


def draw(cfg: GalleryCfg) -> None:
    """Draw and write the pictures."""
    cfg.out.mkdir(parents=True, exist_ok=True)
    _save(category_chart(cfg.quality), cfg.out / "categories.jpg")


def _save(rgb: np.ndarray, path: Path) -> None:
    Image.fromarray(rgb).save(path, quality=_JPEG_QUALITY, optimize=True, progressive=True)


if __name__ == "__main__":
    draw(tyro.cli(GalleryCfg))
