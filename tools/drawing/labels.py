"""Words in pictures."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw, ImageFont

_INK = (255, 255, 255)
_SHADE = (20, 26, 34, 170)


def label(rgb: np.ndarray, text: str, *, size_px: int = 18) -> np.ndarray:
    """A picture with a line of text in its lower left corner."""
    picture = Image.fromarray(rgb).convert("RGBA")
    over = Image.new("RGBA", picture.size)
    draw = ImageDraw.Draw(over)
    font = ImageFont.load_default(size_px)
    left, top, right, bottom = draw.textbbox((0, 0), text, font=font)
    pad = size_px // 3
    x, y = 0, picture.height - (bottom - top) - 2 * pad
    draw.rectangle((x, y, x + right - left + 2 * pad, picture.height), fill=_SHADE)
    draw.text((x + pad - left, y + pad - top), text, font=font, fill=_INK)
    return np.asarray(Image.alpha_composite(picture, over).convert("RGB"))
