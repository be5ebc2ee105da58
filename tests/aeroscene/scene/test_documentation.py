"""The example of docs/scenes.md names the fields that a scene file really has."""

import json
import re
from pathlib import Path

from aeroscene.scene.io import scene_to_json
from aeroscene.sources import load_scene

PAGE = Path(__file__).parents[3] / "docs" / "scenes.md"


def test_the_documented_example_has_the_fields_of_a_scene_file():
    example = json.loads(re.search(r"```json\n(.*?)```", PAGE.read_text(), re.DOTALL).group(1))
    real = json.loads(scene_to_json(load_scene("28")))
    assert set(example) == set(real)
    for part in ("objects", "interaction_areas"):
        assert set(example[part][0]) == set(real[part][0])
    for part in ("extent", "start", "origin"):
        assert set(example[part]) == set(real[part])
