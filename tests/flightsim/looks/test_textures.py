import subprocess
import sys
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.solids.shapes import MATERIALS
from flightsim.looks.textures import PATTERNS, TILE_PIXELS, coarser, tile

TEXTURED = [m for m in MATERIALS.values() if m.texture is not None]
SHARE = st.floats(0.0, 1.0)


def gradient_energy(picture):
    """Mean step of brightness from pixel to pixel, of 255."""
    grey = picture.astype(float).mean(axis=2)
    return np.abs(np.diff(grey, axis=0)).mean() + np.abs(np.diff(grey, axis=1)).mean()


@pytest.mark.parametrize("material", TEXTURED, ids=[m.name for m in TEXTURED])
def test_every_textured_material_gives_a_camera_edges_to_see(material):
    assert material.texture in PATTERNS
    picture = tile(material.texture, material.rgba[:3])
    assert picture.shape[0] == picture.shape[1] >= TILE_PIXELS
    assert picture.dtype == np.uint8
    assert gradient_energy(picture) > 1.5
    assert picture.astype(float).mean(axis=2).std() > 2.0


def test_patterns_differ():
    digests = {zlib.crc32(tile(name, (0.5, 0.4, 0.3)).tobytes()) for name in PATTERNS}
    assert len(digests) == len(PATTERNS)


@pytest.mark.parametrize("name", ["grass", "brick", "wood", "asphalt", "roof_red", "leaves"])
def test_tile_keeps_the_colour_of_its_material(name):
    material = MATERIALS[name]
    mean = tile(material.texture, material.rgba[:3]).reshape(-1, 3).mean(axis=0) / 255
    np.testing.assert_allclose(mean, material.rgba[:3], atol=0.12)


@given(st.sampled_from(sorted(PATTERNS)), SHARE, SHARE, SHARE)
def test_other_colours_lie_between_black_and_white(texture, red, green, blue):
    black, white = (tile(texture, (level,) * 3).astype(int) for level in (0.0, 1.0))
    picture = tile(texture, (red, green, blue)).astype(int)
    assert (picture >= np.minimum(black, white) - 1).all()
    assert (picture <= np.maximum(black, white) + 1).all()


def test_tiles_are_the_same_in_every_process():
    names = ["leaves", "shop_front", "gravel", "wood"]
    code = (
        "import sys, zlib; from flightsim.looks.textures import tile;"
        "print(*[zlib.crc32(tile(n, (0.3, 0.5, 0.2)).tobytes()) for n in sys.argv[1:]])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *names], capture_output=True, text=True, check=True
    )
    here = [zlib.crc32(tile(name, (0.3, 0.5, 0.2)).tobytes()) for name in names]
    assert [int(word) for word in done.stdout.split()] == here


def test_kept_tiles_cannot_be_painted_over():
    with pytest.raises(ValueError, match="read-only"):
        tile("brick", (0.5, 0.5, 0.5))[0, 0] = 0


SEAMLESS = ["grass", "asphalt", "water", "leaves", "gravel", "stone_wall", "soil", "bark"]


@pytest.mark.parametrize("texture", SEAMLESS)
@pytest.mark.parametrize("axis", [0, 1])
def test_tile_repeats_without_a_seam(texture, axis):
    picture = np.moveaxis(tile(texture, (0.5, 0.5, 0.5)).astype(float), axis, 0)
    inside = np.abs(np.diff(picture, axis=0)).mean()
    across = np.abs(picture[0] - picture[-1]).mean()
    assert across < 1.6 * inside + 1.0


def test_coarser_tile_has_the_same_mean():
    picture = tile("brick", (0.7, 0.4, 0.3))
    small = coarser(picture, 8)
    assert small.shape == (picture.shape[0] // 8, picture.shape[1] // 8, 3)
    np.testing.assert_allclose(small.mean(axis=(0, 1)), picture.mean(axis=(0, 1)), atol=0.6)
