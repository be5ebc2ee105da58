"""Transfers at heavy loss end equal, and what does not is seen."""

import measure_loss

from flightsim.mavlink.mission import MissionService
from flightsim.mavlink.mission_upload import Upload


def test_at_a_quarter_lost_all_of_it_comes_back_equal():
    runs = [measure_loss.run(0.25, seed, n_items=40) for seed in range(2)]
    row = measure_loss.summed_up(0.25, runs)
    assert row.is_sound, row
    assert 0.2 < row.lost_share < 0.3
    assert row.median_repeats > 20
    assert runs[0] == measure_loss.run(0.25, 0, n_items=40)


def test_a_vehicle_that_does_not_repeat_itself_is_noticed(monkeypatch):
    monkeypatch.setattr(Upload, "update", lambda _: None)
    monkeypatch.setattr(MissionService, "_repeat_ack", lambda *_: None)
    row = measure_loss.summed_up(0.25, [measure_loss.run(0.25, 0, n_items=40, tries=3)])
    assert not row.is_sound
    assert row.n_gave_up > 0
