from __future__ import annotations

import pytest

from aeroscene.scene.catalogue import CATALOGUE, by_name, category_id


def test_there_are_23_coarse_and_47_fine_categories_numbered_from_one():
    levels = [CATALOGUE[number].level for number in range(1, 71)]
    assert levels == ["coarse"] * 23 + ["fine"] * 47
    assert len(CATALOGUE) == 70


def test_names_are_unique_and_lead_back_to_ids():
    assert len(by_name()) == 70
    assert all(category_id(c.name) == c.id for c in CATALOGUE.values())


@pytest.mark.parametrize("category", CATALOGUE.values(), ids=lambda c: c.name)
def test_size_ranges_are_real_sizes(category):
    for low, high in (category.length_m, category.width_m, category.height_m):
        assert 0.005 < low < high < 130
    assert category.supports
    assert category.surface
