"""Pictures and data as DiffuScene's authors take them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.layouts.flyable import make_flyable
from aeroscene.layouts.neutral_format import neutral_layout
from aeroscene.scene import Scene
from scenarios.cli.main import main
from scenarios.evaluation.class_colours import HALF_M, ClassPictures
from scenarios.evaluation.renders import PIXELS
from scenarios.evaluation.rows import classification_accuracy
from tests.aeroscene.layouts.samples import house


@pytest.fixture(scope="module")
def room() -> Scene:
    return make_flyable(neutral_layout(house()))[0]


def picture(scene: Scene, camera: ClassPictures) -> np.ndarray:
    (found,) = camera.pictures(scene)
    return found.astype(int)


def without_fine(scene: Scene) -> Scene:
    kept = tuple(obj for obj in scene.objects if obj.is_coarse)
    return replace(scene, objects=kept, interaction_areas=())


def test_furniture_alone_is_in_the_picture(room: Scene):
    camera = ClassPictures.from_scenes([room])
    assert (picture(without_fine(room), camera) == 255).all()
    assert (picture(room, camera) != 255).any()


def test_a_class_has_a_colour_of_its_own_and_a_strange_one_is_grey(room: Scene):
    camera = ClassPictures.from_scenes([room])
    assert len(camera.classes) > 1
    seen = {tuple(rgb) for rgb in picture(room, camera).reshape(-1, 3).tolist()}
    assert len(seen) > len(camera.classes)
    strange = picture(room, ClassPictures(()))
    assert (128, 128, 128) in {tuple(rgb) for rgb in strange.reshape(-1, 3).tolist()}


def test_an_object_covers_as_many_pixels_as_its_area_has(room: Scene):
    obj = next(obj for obj in room.objects if not obj.is_coarse and obj.parent_id is not None)
    floor = next(each for each in room.objects if each.category == "room")
    box = replace(obj.bbox, p=(*floor.bbox.p[:2], 0.5), q=(1.0, 0.0, 0.0, 0.0), s=(2.0, 1.0, 1.0))
    one_room = tuple(each for each in without_fine(room).objects if each is floor)
    alone = replace(room, objects=(*one_room, replace(obj, bbox=box)), interaction_areas=())
    shown = picture(alone, ClassPictures.from_scenes([alone]))
    inked = (255 - shown).sum() / (255 - shown[PIXELS // 2, PIXELS // 2]).sum()
    assert inked * (2 * HALF_M / PIXELS) ** 2 == pytest.approx(2.0, rel=0.02)
    rows, columns = np.nonzero((shown != 255).any(axis=2))
    assert np.ptp(columns) == pytest.approx(2 * np.ptp(rows), abs=3)


def test_a_room_of_no_layout_is_refused_with_those_that_there_are(capsys, tmp_path):
    path = tmp_path / "rooms.jsonl"
    layouts = [
        {**house(), "scene_id": kind, "attributes": {"room_type": kind}}
        for kind in ("study", "hall")
    ]
    path.write_text("\n".join(json.dumps(each) for each in layouts))
    for args, room in ((("--room", "attic"), "attic"), (("--protocol", "diffuscene"), "bedroom")):
        asked = ["evaluate", "--data", "front3d", "--path", str(path), *args]
        with pytest.raises(SystemExit) as stop:
            main([*asked, "--out", str(tmp_path / "out")])
        assert stop.value.code == 2
        told = capsys.readouterr().err
        assert f"room {room!r} is none of" in told
        assert "valid: 'hall', 'study'" in told
    assert not (tmp_path / "out").exists()


def test_the_protocol_is_of_rooms(capsys, tmp_path):
    with pytest.raises(SystemExit) as stop:
        main(["evaluate", "--protocol", "diffuscene", "--out", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert "data is 'corpus'; valid: front3d or procthor" in capsys.readouterr().err


def test_pictures_of_one_kind_are_a_guess_and_others_give_themselves_away():
    rng = np.random.default_rng(3)
    real, alike = rng.normal(size=(60, 1, 40)), rng.normal(size=(60, 1, 40))
    other = alike + np.where(np.arange(40) < 5, 4.0, 0.0)
    guess, seen = (classification_accuracy(each, real, rng) for each in (alike, other))
    assert guess.low < 50.0 < guess.high
    assert seen.value > 95.0
