"""What a campaign reports while it flies: the first of each kind of failure, and how far it is."""

import json
from pathlib import Path

import pytest

from scenarios.cli import campaign
from scenarios.cli.campaign_progress import CampaignProgress

AGAIN = "aeroscene fly --out 'a b' --scene 7 --vehicle iris --trial 2"


@pytest.fixture
def titles():
    return []


@pytest.fixture
def tell(titles, capsys):
    """Feed rows to the news; returns the lines on standard error."""

    def feed(codes, *, has_bar, known=()):
        news = CampaignProgress(Path("a b"), len(codes), known, has_bar=has_bar)
        for number, code in enumerate(codes):
            success = None if code == "no_task" else code == "success"
            row = {"trial_id": f"7/iris/{number}", "scene": "7", "vehicle": "iris"}
            row |= {"trial": number, "success": success, "code": code, "reason": f"why\n{number}"}
            news.add(row, lambda _=1, /, title=None: titles.append(title))
        return capsys.readouterr().err.splitlines()

    return feed


def test_each_kind_of_failure_is_told_once_and_the_command_once(tell, titles):
    codes = ["success", "no_task", "raised", "raised", "collided", "success", "collided"]
    assert tell(codes, has_bar=True) == [
        "aeroscene campaign: first trial that is raised: 7/iris/2: why 2",
        f"aeroscene campaign: to fly it again and record it: {AGAIN}",
        "aeroscene campaign: first trial that is collided: 7/iris/4: why 4",
    ]
    assert titles[0] == "success so far 100.0%"
    assert titles[-1] == "success so far 33.3%"


@pytest.mark.parametrize(("n", "period"), [(1, 1), (19, 1), (600, 30), (10_000, 100)])
def test_without_a_terminal_progress_is_a_line_every_so_many_trials(tell, n, period):
    lines = tell(["success"] * n, has_bar=False)
    assert len(lines) == -(-n // period)
    assert lines[-1].startswith(f"aeroscene campaign: {n} of {n} trials flown, success so far 100")
    assert lines[0].startswith(f"aeroscene campaign: {period} of {n} trials flown")


def test_trials_from_before_count_in_the_rate(tell):
    (line,) = tell(["success"], has_bar=False, known=[False, False, False, None])
    assert line.endswith("1 of 1 trials flown, success so far 25.0%; 1 success")


@pytest.mark.parametrize(
    ("codes", "status"),
    [
        ({"raised": 3}, 1),
        ({"raised": 2, "hung": 1, "died": 1}, 1),
        ({"raised": 2, "contact": 1}, 0),
        ({}, 0),
    ],
)
def test_a_campaign_of_nothing_but_mishaps_ends_with_status_1(
    monkeypatch, capsys, tmp_path, codes, status
):
    monkeypatch.setattr(campaign, "_fly", lambda _: {"codes": codes})
    assert campaign.run(campaign.CampaignCfg(out=tmp_path, json=True)) == status
    assert json.loads(capsys.readouterr().out)["codes"] == codes
