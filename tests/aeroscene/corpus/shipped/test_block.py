from hypothesis import given, settings
from hypothesis import strategies as st

from aeroscene.corpus.shipped.block import decode_block, encode_block
from aeroscene.scene.io import scene_to_json
from tests.aeroscene.conftest import SAMPLE, cached_scene
from tests.aeroscene.corpus.shipped.scenes import scenes


@settings(max_examples=100)
@given(st.lists(scenes(), min_size=1, max_size=3))
def test_any_scene_comes_back_as_the_same_document(group):
    block = decode_block(encode_block(group))
    for place, scene in enumerate(group):
        found = block.scene(place)
        assert found == scene
        assert scene_to_json(found) == scene_to_json(scene)


def test_curated_scenes_come_back_in_a_fraction_of_their_json():
    group = [cached_scene(index) for index in SAMPLE]
    data = encode_block(group)
    block = decode_block(data)
    texts = [scene_to_json(scene) for scene in group]
    assert [scene_to_json(block.scene(place)) for place in range(len(group))] == texts
    # 5 MB for the 1,016 scenes would be 4,900 bytes each.
    assert len(data) < 4000 * len(group)


def test_equal_scenes_give_equal_bytes():
    group = [cached_scene(index) for index in SAMPLE[:2]]
    assert encode_block(group) == encode_block(list(group))
