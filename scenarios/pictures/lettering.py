"""Text in pictures that are arrays of pixels, drawn by Pillow in its own font."""

from __future__ import annotations

import functools

import numpy as np
from jaxtyping import UInt8
from PIL import Image, ImageDraw, ImageFont

Picture = UInt8[np.ndarray, "height width 3"]

PAPER_RGB, INK_RGB, PALE_RGB = (250, 250, 248), (28, 32, 38), (112, 118, 126)
_ON_SHADE_RGB = (255, 255, 255)
_SHADE_RGBA = (20, 26, 34, 170)


@functools.cache
def _font(size_px: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size_px)


def write(
    picture: Picture, text: str, place_px: tuple[int, int], size_px: int, rgb: tuple[int, int, int]
) -> None:
    """Write a line of text into a picture.

    Args:
        picture: Picture; changed.
        text: Line of text.
        place_px: Column and row of the text's upper left corner.
        size_px: Height of the letters.
        rgb: Colour, 0 to 255 each.
    """
    image = Image.fromarray(picture)
    ImageDraw.Draw(image).text(place_px, text, font=_font(size_px), fill=rgb)
    picture[:] = np.asarray(image)


def label(picture: Picture, text: str, *, size_px: int = 18) -> Picture:
    """Return a picture with a line of text on a dark shade in its lower left corner.

    Args:
        picture: Picture; it is not changed.
        text: Line of text.
        size_px: Height of the letters.
    """
    image = Image.fromarray(picture).convert("RGBA")
    over = Image.new("RGBA", image.size)
    draw = ImageDraw.Draw(over)
    left, top, right, bottom = draw.textbbox((0, 0), text, font=_font(size_px))
    pad = size_px // 3
    x, y = 0, image.height - (bottom - top) - 2 * pad
    # The box of a text does not begin at its origin, hence the offsets.
    draw.rectangle((x, y, x + right - left + 2 * pad, image.height), fill=_SHADE_RGBA)
    draw.text((x + pad - left, y + pad - top), text, font=_font(size_px), fill=_ON_SHADE_RGB)
    return np.array(Image.alpha_composite(image, over).convert("RGB"))
