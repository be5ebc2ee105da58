"""English of descriptions, and what each direction is called from another side."""

import numpy as np
import pytest

from scenarios.words.description_text import noun_phrase, text_of
from scenarios.words.goal import Beside, Description, Has, Nearest, Of, On, Toward

CAR = Description(kind="car", colour="red")


def phrases(description):
    return {noun_phrase(description, np.random.default_rng(seed)) for seed in range(40)}


@pytest.mark.parametrize(
    ("direction", "words"),
    [
        ("north", {"behind {} as seen from the south", "to the right of {} as seen from the east"}),
        ("east", {"to the right of {} as seen from the south", "to the east of {}"}),
        ("south", {"behind {} as seen from the north", "to the left of {} as seen from the east"}),
        ("west", {"to the left of {} as seen from the south", "west of {}"}),
    ],
)
def test_sides_are_told_from_where_one_stands(direction, words):
    found = phrases(Description(kind="kiosk", links=(Toward(direction, CAR),)))
    assert {f"the kiosk {word.format('the red car')}" for word in words} <= found


def test_two_viewpoints_never_meet_in_one_text():
    near = Description(kind="bench", links=(Toward("north", CAR),))
    for text in phrases(Description(kind="kiosk", links=(Toward("east", near),))):
        assert "as seen from" not in text


def test_a_chain_says_what_belongs_to_what():
    house = Description(kind="house", links=(Has(1, "tree"),))
    roof = Description(kind="roof", links=(Has(2, "solar_panel"), Toward("north", house)))
    expected = "the roof with two solar panels on it, north of the house with a tree on it"
    assert expected in phrases(roof)
    of = Description(kind="roof", links=(Of(CAR), Nearest(CAR)))
    assert "the roof of the red car, nearest to the red car" in phrases(of)
    two = Description(kind="kiosk", links=(Beside(CAR), Nearest(CAR)))
    assert "the kiosk that is beside the red car and closest to the red car" in phrases(two)


def test_forms_and_storeys_stand_where_they_belong():
    room = Description(kind="room", form="carpet", storey=1, links=(Has(3, "chair"),))
    assert phrases(room) == {"the room one floor up with the carpet and three chairs in it"}


def test_what_follows_a_form_is_the_places_own():
    pad = Description(kind="landing_pad", form="cross", links=(Beside(CAR),))
    assert "the landing pad with a white cross, beside the red car" in phrases(pad)


def test_a_landmark_says_that_it_is_the_one_on_its_host():
    van = Description(kind="van", links=(On(Description(kind="lawn")),))
    text = "the car closest to the van that stands on the lawn"
    assert text in phrases(Description(kind="car", links=(Nearest(van),)))
    assert phrases(van) == {"the van on the lawn"}


def test_an_order_is_one_or_two_sentences():
    texts = {text_of(CAR, np.random.default_rng(seed)) for seed in range(200)}
    assert len(texts) > 12
    assert all(text[0].isupper() and text.endswith(".") and "{" not in text for text in texts)
