"""The demo over hills: it plans over the ground, flies there and lands on it."""

import json

import pytest

from aeroscene.sources import load_scene
from tests.instances import own_instance
from tests.scenarios.in_process import in_process
from tests.thorough import THOROUGH


@pytest.mark.parametrize(
    "options",
    [
        pytest.param((), marks=THOROUGH),
        ("--wind", "4", "--vehicle", "hummingbird", "--seed", "3"),
    ],
)
def test_the_demo_lands_in_a_scene_with_hills(capsys, options):
    args = ("sitl", "hills", "--demo", "--speed", "max", "--json", "--instance", own_instance())
    status, out, err = in_process(capsys, *args, *options)
    assert status == 0, out + err
    result = json.loads(out)
    assert result["code"] == "landed"
    assert result["contacts_before_touchdown"] == 0
    area = load_scene("hills").interaction_areas[result["landed_area"]]
    assert [c["what"] for c in result["contacts"]] == [
        "the ground" if area.object_id is None else "object 1 (landing_pad)"
    ]
