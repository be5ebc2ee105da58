"""A language is the same when it comes back from a checkpoint."""

import json

from aeroscene.learning.program import EncodingCfg
from aeroscene.learning.wishes import Wish
from aeroscene.learning.writer.examples import ProgramEncoder, encodable
from aeroscene.learning.writer.language import Language, learn_language
from tests.aeroscene.conftest import cached_scene


def test_a_checkpoint_keeps_arrays_and_companions_of_its_scenes(language):
    kept = Language.restored(language.to_json(), language.to_arrays())
    companions = language.statistics.companions
    assert companions.by_bond
    assert kept.statistics.companions == companions
    assert 0.0 < language.syntax.has_shape.mean() < 0.5
    assert (kept.syntax.has_shape == language.syntax.has_shape).all()


def test_a_checkpoint_encodes_scenes_as_its_training_was():
    scenes = [cached_scene(number) for number in (7, 42)]
    cfg = EncodingCfg(has_partitions=False, has_relations=False)
    encoded, _ = encodable(scenes, cfg)
    language = learn_language(encoded, cfg)
    kept = Language.restored(language.to_json(), language.to_arrays())
    assert kept.encoding == cfg
    written = [ProgramEncoder(kept)(scene, Wish.from_scene(scene)) for scene in scenes]
    assert [len(each.example.skeleton) for each in written] == [
        len(each.program.kinds) for each in encoded
    ]


def test_an_older_checkpoint_allows_all_arrays_and_companions(language):
    arrays = {name: each for name, each in language.to_arrays().items() if name != "has_shape"}
    text = json.loads(language.to_json())
    del text["companions"]
    kept = Language.restored(json.dumps(text), arrays)
    assert kept.syntax.has_shape.all()
    assert not kept.statistics.companions.by_bond


def test_draws_have_only_arrays_that_the_same_thing_had(language):
    """Of the families with groups each has some arrays, and none has all."""
    syntax = language.syntax
    groups = [i for i, kind in enumerate(language.vocabulary.kinds) if kind.is_group]
    for kind in groups:
        allowed = syntax.shapes(kind)
        assert allowed.any()
        assert not allowed[0]
        assert not allowed.all()
