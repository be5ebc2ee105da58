from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.layouts import LayoutObject, MappingReport, read_neutral
from aeroscene.layouts.mapping import building_kind, form_of, match, match_name
from aeroscene.layouts.tables import FORMS, SAME, STAND_INS, SUPER_CATEGORIES, WORDS
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import by_name, category_id
from aeroscene.solids.shapes import object_primitives
from tests.aeroscene.sampling_solids import bounds

TARGETS = sorted({*SAME, *STAND_INS, *SUPER_CATEGORIES.values(), *WORDS, "garage", "tower"})
sizes = st.tuples(*[st.floats(0.004, 6.0)] * 3)


def test_tables_lead_to_our_categories_and_name_everything_once():
    assert set(TARGETS) <= set(by_name())
    names = [name for table in (SAME, STAND_INS) for group in table.values() for name in group]
    assert [name for name, count in Counter(names).items() if count > 1] == []
    pinned = [name for group in FORMS.values() for name in group]
    assert set(pinned) <= set(names)


@pytest.mark.parametrize(
    ("name", "category", "fit"),
    [
        ("Dining Chair", "chair", "same"),
        ("Pendant Lamp", "lamp", "same"),
        ("Egg", "box", "stand-in"),
        ("street_lamp", "street_lamp", "same"),
        ("Street Lamps", "street_lamp", "same"),
        ("SM_PalmTree_03", "tree", "by word"),
        ("table lamp 2", "lamp", "by word"),
        ("WeefitBuilding", "building", "by word"),
        ("sofa/left corner sofa", "sofa", "by word"),
        ("desk chair", "chair", "by word"),
        ("car park", "parking_lot", "same"),
    ],
)
def test_names_map_by_table_and_by_their_last_known_word(name, category, fit):
    found = match_name(name)
    assert found is not None
    assert (found.category, found.fit) == (category, fit)


@pytest.mark.parametrize("name", ["", "7", "xyzzy", "scarf", "cartoon"])
def test_names_without_a_known_word_do_not_map(name):
    assert match_name(name) is None


def test_the_wider_category_decides_where_the_name_is_unknown():
    obj = LayoutObject(
        category="xyzzy", super_category="Lighting", p=(0, 0, 0), q=(1, 0, 0, 0), s=(1, 1, 1)
    )
    found = match(obj)
    assert found is not None
    assert (found.category, found.fit) == ("lamp", "by super-category")


def test_buildings_are_told_apart_by_size():
    kinds = {size: building_kind(size) for size in [(5, 4, 2.8), (12, 9, 5), (30, 12, 9)]}
    assert list(kinds.values()) == ["garage", "house", "building"]
    assert building_kind((10, 10, 30)) == "tower"


def test_reports_add_up():
    first = MappingReport(
        n_scenes=1,
        n_objects=4,
        mapped={("Egg", "box", "stand-in"): 2},
        unmapped={"Scarf": 1},
        unmapped_first={"Scarf": "scene 'a': object 3"},
        dropped={"below the floor": 1},
    )
    second = MappingReport(
        n_scenes=1,
        n_objects=3,
        mapped={("Egg", "box", "stand-in"): 1, ("Bed", "bed", "same"): 1},
        unmapped={"Scarf": 1},
        unmapped_first={"Scarf": "scene 'b': object 0"},
        invalid=("scene 'b': object 7: s is ...",),
    )
    total = first + second
    assert (total.n_scenes, total.n_objects, total.n_mapped) == (2, 7, 4)
    assert total.by_category == {"box": 3, "bed": 1}
    assert total.by_fit == {"same": 1, "stand-in": 3}
    assert total.unmapped == {"Scarf": 2}
    assert total.unmapped_lines[0].startswith("scene 'a': object 3: category is 'Scarf'; valid: ")
    plain = total.to_plain()
    assert plain["mapped_by_name"]["Egg"] == {
        "count": 3,
        "fit": "stand-in",
        "categories": {"box": 3},
    }
    assert plain["invalid"] == 1


@given(st.sampled_from(TARGETS), sizes, st.sampled_from([None, *FORMS]))
def test_any_size_of_a_mapped_category_gives_solids_within_its_box(category, size, form):
    obj = SceneObject(
        id=3,
        scene_id="s",
        parent_id=None,
        category_id=category_id(category),
        bbox=OrientedBox((0, 0, 0), (1, 0, 0, 0), size),
        domain="indoor",
        attributes={"form": form} if form else {},
    )
    solids = [solid for solid in object_primitives(obj) if solid.collides]
    assert solids
    for solid in solids:
        low, high = bounds(solid)
        assert np.all(high > low)
        assert np.all(np.maximum(-low, high) <= np.asarray(size) / 2 + 0.05)


@pytest.mark.skipif("AEROSCENE_LAYOUTS" not in os.environ, reason="needs real layouts")
def test_every_category_of_real_layouts_maps():
    names = Counter(
        obj.category
        for path in Path(os.environ["AEROSCENE_LAYOUTS"]).glob("*.jsonl.gz")
        for layout in read_neutral(path)
        for obj in layout.objects
    )
    assert names
    assert [name for name in names if match_name(name) is None] == []
    assert form_of("Bowl") == "bowl"
