"""What one run writes is bounded, and takes no file's place."""

import pytest

from flightsim.payload import card as card_module
from flightsim.payload.card import Card, CardFullError


def test_files_are_numbered_on_from_those_that_are_there(tmp_path):
    folder = tmp_path / "captures"
    card = Card(folder)
    first = card.new_path("IMG", ".jpg")
    assert first == folder / "IMG_0000.jpg"
    card.write(first, b"one")
    (folder / "IMG_0041.json").write_bytes(b"two")
    (folder / "IMG_mine.jpg").write_bytes(b"three")
    assert Card(folder).new_path("IMG", ".jpg") == folder / "IMG_0042.jpg"
    assert card.new_path("VID", ".mp4") == folder / "VID_0000.mp4"
    assert card.used_bytes == 3


def test_a_full_card_takes_nothing_more(tmp_path, monkeypatch):
    monkeypatch.setattr(card_module, "CAPACITY_BYTES", 10)
    card = Card(tmp_path)
    card.write(tmp_path / "IMG_0000.jpg", b"12345678")
    with pytest.raises(CardFullError, match="no room for 3 bytes"):
        card.write(tmp_path / "IMG_0001.jpg", b"123")
    assert [path.name for path in tmp_path.iterdir()] == ["IMG_0000.jpg"]
    assert card.free_bytes == 2


def test_without_a_folder_there_is_nothing(tmp_path):
    card = Card(None)
    assert card.new_path("IMG", ".jpg") is None
    assert card.free_bytes == 0
