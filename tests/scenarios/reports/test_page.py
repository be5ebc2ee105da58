"""The page of a campaign: true figures, no host, nothing of a pilot's words taken for markup."""

import re
import shlex
from html.parser import HTMLParser

import pytest

from scenarios.reports import findings
from scenarios.reports.page import PAGE, write_report
from tests.scenarios.in_process import in_process
from tests.scenarios.reports.campaigns import campaign, change_manifest, row, trials

TRIALS = trials(6)
REASON = "<script>alert('x')</script> & more"


class Page(HTMLParser):
    """Elements of a page, by their names, with their attributes and the text in them."""

    def __init__(self, text):
        super().__init__()
        self.found, self.open = [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.found.append([tag, dict(attrs), ""])
        if tag not in {"meta", "link", "br"}:
            self.open.append(self.found[-1])

    def handle_startendtag(self, tag, attrs):
        self.found.append([tag, dict(attrs), ""])

    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        for each in self.open:
            each[2] += data

    def of(self, tag, word=""):
        return [
            (attrs, text)
            for name, attrs, text in self.found
            if name == tag and word in attrs.get("class", "")
        ]


@pytest.fixture
def folder(tmp_path):
    rows = [row(trial, trial.number < 4) for trial in TRIALS]
    rows[4]["reason"] = REASON
    return campaign(tmp_path / "a campaign", rows)


def page_of(folder):
    parts = []
    write_report(folder, lambda title, share: parts.append((title, share)))
    assert [share for _, share in parts] == sorted(share for _, share in parts)
    return Page((folder / PAGE).read_text())


def test_a_page_holds_all_that_it_shows_and_asks_no_host(folder):
    page = page_of(folder)
    names = {name for name, *_ in page.found}
    assert names.isdisjoint({"script", "link", "img", "iframe", "object"})
    text = (folder / PAGE).read_text()
    assert not re.search(r"https?:|@import|url\((?!#)", text)
    assert [attrs["href"] for attrs, _ in page.of("a")] == []
    assert "alert('x')" in "".join(text for _, text in page.of("td"))


def test_rates_and_ways_are_those_of_the_rows(folder):
    page = page_of(folder)
    assert [text for _, text in page.of("div", "big")] == ["66.7%", "66.7%", "100.0%"]
    (rows,) = [text for _, text in page.of("tr") if "difficulty medium" in text]
    assert "1 of 2" in rows
    assert "50.0%" in rows
    plan = [attrs["d"] for attrs, _ in page.of("path", "way") if "10.00,-0.00" in attrs["d"]]
    assert len(plan) == 12
    assert plan[0] == "M0.00,-0.00 5.00,-5.00 10.00,-0.00"
    # Two failures and a cross in the key; colour is not all that tells them.
    assert len(page.of("path", "end failed")) == 3
    assert len(page.of("circle", "end landed")) == 5


def test_a_failure_has_its_recording_or_the_command_that_makes_one(folder):
    (folder / "recordings").mkdir()
    (folder / "recordings" / "7-iris-5.rrd").write_bytes(b"")
    page = page_of(folder)
    commands = [shlex.split(text) for _, text in page.of("code", "command")]
    assert commands == [
        [
            *("aeroscene", "fly", "--out", str(folder)),
            *("--scene", "7", "--vehicle", "iris", "--trial", "4"),
        ],
        ["aeroscene", "replay", str(folder / "recordings" / "7-iris-5.rrd")],
    ]
    (link,) = page.of("a")
    assert (folder / link[0]["href"]).is_file()


def test_a_page_says_what_it_leaves_out(folder, monkeypatch):
    monkeypatch.setattr(findings, "MOST_WAYS", 3)
    monkeypatch.setattr(findings, "MOST_FAILURES", 1)
    page = page_of(folder)
    assert "3 of 6 trials, failures first" in "".join(text for _, text in page.of("figcaption"))
    # Two failures and one success, each with its plan.
    assert len(page.of("path", "end failed")) == 3
    assert len(page.of("code", "command")) == 1
    assert any("of 2." in text for _, text in page.of("p"))


def test_campaigns_without_failures_ways_or_trials_have_a_page(tmp_path):
    nothing = {"flown_enu_m": None, "planned_enu_m": None}
    page = page_of(campaign(tmp_path / "good", [row(TRIALS[0], True, **nothing)]))
    assert any(text == "None." for _, text in page.of("p"))
    assert not page.of("svg", "plan")
    page = page_of(campaign(tmp_path / "empty", []))
    assert [text for _, text in page.of("div", "big")] == ["–"] * 3
    died = {"trial_id": "7/iris/0", "scene": "7", "vehicle": "iris", "trial": 0}
    died |= {"success": False, "code": "died", "reason": "its process ended"}
    page = page_of(campaign(tmp_path / "died", [died]))
    assert [text for _, text in page.of("div", "big")] == ["0.0%", "0.0%", "–"]


def test_ways_are_not_drawn_over_other_scenes(folder):
    change_manifest(folder, scenes_sha256="0" * 64)
    page = page_of(folder)
    assert not page.of("svg", "plan")
    assert any(text.startswith("Not drawn: the campaign") for _, text in page.of("p"))


def test_report_names_its_page(folder, capsys):
    status, out, err = in_process(capsys, "report", folder)
    assert (status, err) == (0, "")
    assert f"replays: {folder / PAGE}" in out
