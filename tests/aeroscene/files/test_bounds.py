"""Bounds on what a JSON text may make us build hold before anything is built."""

import json

import pytest

from aeroscene.corpus.field import field_scene
from aeroscene.files.bounds import MOST_JSON_BYTES, MOST_VALUES, count_values, excess
from aeroscene.layouts.document import LayoutError
from aeroscene.layouts.text_file import parse_json
from aeroscene.scene import SceneError
from aeroscene.scene.io import scene_from_json, scene_to_json


@pytest.mark.parametrize("value", [1, "a", [], {}, [1, [2, {"a": 3}]], {"a": {"b": [None] * 7}}])
def test_no_text_has_more_values_than_are_counted(value):
    def values(found):
        if isinstance(found, dict):
            return 1 + sum(1 + values(each) for each in found.values())
        return 1 + sum(map(values, found)) if isinstance(found, list) else 1

    assert count_values(json.dumps(value).encode()) >= values(value)


def test_the_bounds_are_said_with_what_is_valid():
    assert excess(scene_to_json(field_scene())) is None
    assert "valid: at most that" in (excess(b" " * (MOST_JSON_BYTES + 1)) or "")
    assert f"valid: at most {MOST_VALUES}" in (excess(b"," * (MOST_VALUES + 1)) or "")


@pytest.mark.parametrize("read", [scene_from_json, lambda data: parse_json(data, "l.jsonl")])
def test_a_text_of_too_many_values_is_refused_by_their_number(read):
    text = b"[" + b"[]," * (MOST_VALUES // 2) + b"0]"
    with pytest.raises((SceneError, LayoutError), match=f"valid: at most {MOST_VALUES}"):
        read(text)
