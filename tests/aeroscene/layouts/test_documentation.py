from __future__ import annotations

from pathlib import Path

import pytest

from aeroscene.layouts.tables import SAME, STAND_INS, SUPER_CATEGORIES, WORDS

PAGE = Path(__file__).parents[3] / "docs" / "layouts.md"


@pytest.mark.parametrize(
    ("column", "table"), [(2, SAME), (3, STAND_INS), (4, WORDS)], ids=["same", "stand-in", "word"]
)
def test_the_page_lists_every_name_under_its_category(column, table):
    rows = [line.split("|") for line in PAGE.read_text().splitlines() if line.startswith("| ")]
    listed = {row[1].strip(): row[column].strip() for row in rows if len(row) == 6}
    for category, names in table.items():
        assert listed[category] == ", ".join(names)


def test_the_page_lists_the_wider_categories():
    text = " ".join(PAGE.read_text().split())
    assert "; ".join(f"{name}: {ours}" for name, ours in SUPER_CATEGORIES.items()) in text
