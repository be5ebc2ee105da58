"""Layouts that are not ours are flown by our own pilot, from take-off to the landing."""

from __future__ import annotations

import pytest

from flightsim.testbench import TestbenchCfg
from scenarios.run.cfg import SitlCfg
from scenarios.run.sitl import Sitl
from tests.aeroscene.layouts.samples import (
    authors_scene,
    block,
    front3d_house,
    house,
    write_json,
    write_lines,
)
from tests.instances import own_instance
from tests.thorough import THOROUGH

FILES = {
    "house": lambda folder: f"{write_lines(folder / 'l.jsonl', block(), house())}#1",
    "block": lambda folder: f"{write_lines(folder / 'l.jsonl', block(), house())}#block-1",
    "3D-FRONT": lambda folder: str(write_json(folder / "h.json", front3d_house())),
    "authors": lambda folder: str(write_json(folder / "a.json.gz", authors_scene())),
}


@pytest.mark.parametrize(
    "name",
    ["house", "authors", *(pytest.param(each, marks=THOROUGH) for each in ("block", "3D-FRONT"))],
)
def test_a_layout_is_flown_and_landed_in(tmp_path, name):
    vehicle = "hummingbird" if name == "house" else "iris"
    bench = TestbenchCfg(vehicle=vehicle, speed="max", instance=own_instance())
    with Sitl(SitlCfg(scene=FILES[name](tmp_path), bench=bench, demo=True)) as sitl:
        result = sitl.run()
    assert result.success, result.reason
    assert result.contacts_before_touchdown == 0
