import numpy as np
import pytest

from aeroscene.shapes import MATERIALS
from flightsim.looks.textures import TILE_PIXELS, tile

TEXTURED = [m for m in MATERIALS.values() if m.texture is not None]


@pytest.mark.parametrize("texture", sorted({m.texture for m in TEXTURED}))
def test_every_texture_of_a_scene_has_a_pattern_of_its_own(texture):
    picture = tile(texture, (0.5, 0.4, 0.3))
    assert picture.shape[0] == picture.shape[1] >= TILE_PIXELS
    assert picture.shape[2] == 3
    assert picture.dtype == np.uint8
    assert picture.std() > 1.0
    if texture != "plaster":
        assert (picture != tile("no such texture", (0.5, 0.4, 0.3))).any()


@pytest.mark.parametrize("name", ["grass", "brick", "wood", "asphalt", "roof_red"])
def test_tile_keeps_the_colour_of_its_material(name):
    material = MATERIALS[name]
    mean = tile(material.texture, material.rgba[:3]).reshape(-1, 3).mean(axis=0) / 255
    np.testing.assert_allclose(mean, material.rgba[:3], atol=0.12)


def test_tiles_are_the_same_each_time():
    assert (tile("grass", (0.3, 0.5, 0.2)) == tile("grass", (0.3, 0.5, 0.2))).all()


@pytest.mark.parametrize("texture", ["grass", "asphalt", "water", "leaves", "plaster"])
def test_tile_repeats_without_a_seam(texture):
    picture = tile(texture, (0.5, 0.5, 0.5)).astype(float)
    inside = np.abs(np.diff(picture, axis=1)).mean()
    across = np.abs(picture[:, 0] - picture[:, -1]).mean()
    assert across < 1.6 * inside + 1.0
