"""Scenes come back from their programs, and any program gives a scene."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroscene.corpus.curation import curate_scene
from aeroscene.landform import level
from aeroscene.learning.program import (
    DecodingCfg,
    EncodedProgram,
    EncodingCfg,
    Program,
    decode,
    encode,
)
from aeroscene.learning.program.kinds import UnitKind
from aeroscene.learning.program.references import measure_references
from aeroscene.learning.program.statistics import (
    ProgramStatistics,
    from_example,
    measure_programs,
    to_example,
)
from aeroscene.learning.program.vocabulary import ProgramVocabulary
from aeroscene.metrics.places.precision import whole_centimetres
from aeroscene.metrics.places.roads import lights_off_roads, stranded_boats, wrong_way_vehicles
from aeroscene.metrics.places.stairs import dead_end_stairs
from aeroscene.metrics.places.top_view import TopView
from aeroscene.metrics.places.walls import closed_shares
from aeroscene.scene import Scene
from aeroscene.scene.box import MIN_SIZE_M

SEEDS = (0, 1, 6, 5)
Measured = tuple[dict[int, EncodedProgram], ProgramVocabulary, ProgramStatistics]


@pytest.fixture(scope="module")
def scenes() -> dict[int, Scene]:
    return {seed: level(curate_scene(seed)) for seed in SEEDS}


@pytest.fixture(scope="module")
def measured(scenes: dict[int, Scene]) -> Measured:
    encoded = {seed: encode(scene) for seed, scene in scenes.items()}
    return encoded, *measure_programs(list(encoded.values()))


def assert_same(
    scene: Scene, encoded: EncodedProgram, program: Program, cfg: DecodingCfg | None = None
) -> None:
    """Within a centimetre and a degree, with the same words and parents."""
    decoded = decode(program, cfg=cfg)
    assert len(decoded.scene.objects) == len(scene.objects)
    found = {
        own: made
        for some, others in zip(encoded.object_ids, decoded.object_ids, strict=True)
        for own, made in zip(some, others, strict=True)
    }
    assert set(found) == {obj.id for obj in scene.objects}
    for obj in scene.objects:
        made = decoded.scene.object_by_id[found[obj.id]]
        np.testing.assert_allclose(made.bbox.p, obj.bbox.p, atol=0.01)
        np.testing.assert_allclose(made.bbox.s, obj.bbox.s, atol=0.02)
        assert abs(np.dot(made.bbox.q, obj.bbox.q)) > math.cos(math.radians(0.5))
        assert (made.category, made.domain) == (obj.category, obj.domain)
        assert made.parent_id == (None if obj.parent_id is None else found[obj.parent_id])
        assert (
            made.attributes.items()
            >= {
                name: value for name, value in obj.attributes.items() if isinstance(value, str)
            }.items()
        )


@pytest.mark.parametrize("seed", SEEDS)
def test_scene_comes_back_from_its_program(
    seed: int, scenes: dict[int, Scene], measured: Measured
) -> None:
    encoded = measured[0][seed]
    assert_same(scenes[seed], encoded, encoded.program)


@pytest.mark.parametrize("has_partitions", [True, False])
@pytest.mark.parametrize("has_relations", [True, False])
def test_scene_comes_back_from_a_program_that_says_less(
    scenes: dict[int, Scene], has_partitions: bool, has_relations: bool
) -> None:
    cfg = EncodingCfg(has_partitions=has_partitions, has_relations=has_relations)
    for scene in scenes.values():
        encoded = encode(scene, cfg)
        assert_same(scene, encoded, encoded.program, DecodingCfg(makes_room=False, mends=False))
        kinds = encoded.program.kinds
        assert any(kind.node in {"site", "storey"} for kind in kinds) == has_partitions
        relations = {kind.relation for kind in kinds if kind.node == "unit"}
        assert (relations == {"SCATTER"}) != has_relations
        assert any(kind.is_group for kind in kinds) == has_relations


@pytest.mark.parametrize("seed", SEEDS)
def test_scene_comes_back_through_standardised_channels(
    seed: int, scenes: dict[int, Scene], measured: Measured
) -> None:
    encoded, vocabulary, statistics = measured
    example = to_example(encoded[seed], vocabulary, statistics)
    program = from_example(example, vocabulary, statistics)
    own = encoded[seed].program
    # Clearances move the twentieth of the units that training has nearer than them.
    program = replace(program, looks=own.looks, clearances=own.clearances)
    assert_same(scenes[seed], encoded[seed], program)


def noisy(measured: Measured, seed: int, rng: np.random.Generator, share: float = 1.0) -> Scene:
    """A scene whose free channels are off by a standard deviation, or nothing but noise."""
    encoded, vocabulary, statistics = measured
    example = to_example(encoded[seed], vocabulary, statistics)
    x0 = share * example.x0 + rng.normal(size=example.x0.shape)
    return decode(from_example(replace(example, x0=x0), vocabulary, statistics)).scene


def test_drawn_extents_are_whole_centimetres_unless_decoding_leaves_them(
    measured: Measured,
) -> None:
    encoded, vocabulary, statistics = measured
    example = to_example(encoded[1], vocabulary, statistics)
    x0 = example.x0 + 0.01 * np.random.default_rng(0).normal(size=example.x0.shape)
    program = from_example(replace(example, x0=x0), vocabulary, statistics)
    shares: dict[bool, float] = {}
    for rounds in (True, False):
        scene = decode(program, cfg=DecodingCfg(rounds=rounds)).scene
        shares[rounds] = float(np.mean(whole_centimetres(TopView(scene))))
    assert shares[True] == 1.0
    assert shares[False] < 0.8


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("noise_seed", range(3))
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_any_numbers_give_a_place(
    measured: Measured, seed: int, noise_seed: int, share: float
) -> None:
    scene = noisy(measured, seed, np.random.default_rng(noise_seed), share)
    sizes_m = np.array([obj.bbox.s for obj in scene.objects])
    assert sizes_m.min() >= MIN_SIZE_M
    assert sizes_m.max() <= 1100
    view = TopView(scene)
    assert not lights_off_roads(view).any()
    assert not stranded_boats(view).any()
    assert not wrong_way_vehicles(view).any()
    assert dead_end_stairs(view).sum() <= 1
    assert closed_shares(view).size == 0 or np.median(closed_shares(view)) > 0.98


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("swap_seed", range(2))
def test_swapped_kinds_give_a_scene(measured: Measured, seed: int, swap_seed: int) -> None:
    encoded, vocabulary, statistics = measured
    rng = np.random.default_rng(swap_seed)
    example = to_example(encoded[seed], vocabulary, statistics)
    kind = example.skeleton.kind_id.copy()
    for place in range(1, len(kind)):
        own = vocabulary.kinds[kind[place]]
        if rng.random() < 0.1:
            like = [
                number
                for number, other in enumerate(vocabulary.kinds)
                if (other.node, other.is_coarse) == (own.node, own.is_coarse)
            ]
            kind[place] = rng.choice(like)
    skeleton = replace(example.skeleton, kind_id=kind)
    program = from_example(replace(example, skeleton=skeleton), vocabulary, statistics)
    assert decode(program).scene.objects


def test_kind_that_the_corpus_has_not_is_the_nearest(measured: Measured) -> None:
    _, vocabulary, _ = measured
    for kind in vocabulary.kinds:
        assert vocabulary.kinds[vocabulary.nearest(kind)] == kind
    unknown = UnitKind("unit", "tree", "outdoor", relation="OVER", side=3, gap="WIDE", turn=2)
    assert vocabulary.kinds[vocabulary.nearest(unknown)].category == "tree"
    with pytest.raises(KeyError, match="unit zeppelin"):
        vocabulary.nearest(UnitKind("unit", "zeppelin"))


def test_stairs_count_from_the_level_that_they_lead_to(measured: Measured) -> None:
    encoded, vocabulary, _ = measured
    references = measure_references(list(encoded.values()))
    stairs = [k for k in vocabulary.kinds if k.category == "stairs" and k.relation == "SIDE"]
    assert stairs
    assert any(references.of(kind)[3] == 2 for kind in stairs)
