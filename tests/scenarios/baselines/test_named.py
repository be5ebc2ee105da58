"""Pilots by name: ours, those that ship, and a class in a module of one's own."""

import importlib

import pytest

from scenarios.baselines.named import BASELINES, NamedPilot, PilotError, pilot_of
from scenarios.run.cfg import SitlCfg

PILOT = """
class Stay:
    pass


number = 3
"""


def test_pilots_are_named_by_module_and_class(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "stay_pilot_of_test.py").write_text(PILOT)
    assert pilot_of("stay_pilot_of_test:Stay").make.__name__ == "Stay"
    for text, reason in (
        (
            "stay_pilot_of_test",
            "'stay_pilot_of_test'; valid: demo, mueller, potential, straight, random",
        ),
        ("stay_pilot_of_test:Go", "has no attribute 'Go'; valid: demo"),
        ("stay_pilot_of_test:number", "is no class"),
        ("no_such_module:Pilot", "No module named 'no_such_module'; valid: demo"),
    ):
        with pytest.raises(PilotError, match=reason) as caught:
            pilot_of(text)
        assert "\n" not in str(caught.value)


def test_pilots_that_ship_are_ours_by_its_planners_and_other_classes():
    assert pilot_of("demo") == NamedPilot()
    assert pilot_of("mueller") == NamedPilot(planner="primitives")
    for name, where in BASELINES.items():
        pilot = pilot_of(name)
        module, _, member = where.partition(":")
        assert pilot.make is getattr(importlib.import_module(module), member)
        assert pilot.brief(SitlCfg(demo=True)) == SitlCfg()
    for name, planner in (("demo", "optimise"), ("mueller", "primitives")):
        brief = pilot_of(name).brief(SitlCfg(area=3))
        assert brief == SitlCfg(demo=True, area=3, planner=planner)
