from dataclasses import replace

import pytest
import torch

from aeroscene.learning.diffusion.sampling import Moment
from aeroscene.learning.diffusion.schedule import DiffusionError
from aeroscene.learning.guidance.contacts import near_pairs, overlap
from aeroscene.learning.guidance.separation import SeparationCfg, SeparationGuidance
from aeroscene.learning.guidance.tree import lineage
from aeroscene.learning.tokens.batch import Collator
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.examples import encode_corpus
from aeroscene.learning.tokens.kinds import count_kinds
from tests.aeroscene.conftest import cached_scene
from tests.aeroscene.learning.guidance.layouts import decode_metres, world_batch

LAST = Moment(29, 30, 0.03, 0.99, None)
LATE = Moment(25, 30, 0.2, 0.9, None)
EARLY = Moment(2, 30, 0.9, 0.1, None)


class World:
    """A few boxes by hand below a site, whose channels are metres in the parents' axes."""

    def __init__(self, rows: list[tuple], *, n_coarse: int = 1, border_m: float = 50.0) -> None:
        """Rows of parent, x, y, yaw, underside, and extents a, b, c."""
        rows = [(0, 0, 0, 0, 0, 100, 100, 50), *rows]
        values = torch.tensor([row[1:] for row in rows], dtype=torch.float32)[None]
        heading = torch.stack([values[..., 2].cos(), values[..., 2].sin()], dim=-1)
        self.batch = world_batch([row[0] for row in rows], n_coarse)
        self.x0 = torch.cat([values[..., :2], torch.zeros_like(values[..., :1])], dim=-1)
        self.decode = decode_metres(values[..., 4:], heading, values[..., 3])
        low = torch.full((1, len(rows), 3), -border_m)
        self.bounds = (low, -low)

    def guidance(self, **settings) -> SeparationGuidance:
        return SeparationGuidance(self.decode, lambda _: self.bounds, SeparationCfg(**settings))

    def settle(self, at: Moment = LAST, **settings) -> torch.Tensor:
        return self.guidance(**settings).on_x0(self.x0, self.batch, at)

    def worst(self, x0: torch.Tensor) -> float:
        return max(_depths(self.decode(x0, self.batch), self.batch), default=0.0)


def _depths(boxes, batch) -> list[float]:
    above = lineage(batch)
    pairs = near_pairs(boxes, above | above.transpose(1, 2), 0.0)
    depth = overlap(pairs)
    return depth[depth > 0].tolist()


def test_two_equal_boxes_part_by_half_each_along_the_shorter_way():
    world = World([(0, 0.0, 0, 0, 0, 1, 1, 1), (0, 0.8, 0.1, 0, 0, 1, 1, 1)])
    moved = world.settle() - world.x0
    assert world.worst(world.settle()) < 0.01
    assert moved[0, 1, :2].tolist() == pytest.approx([-0.1, 0], abs=0.01)
    assert moved[0, 2, :2].tolist() == pytest.approx([0.1, 0], abs=0.01)


def test_thin_slabs_part_sideways_and_never_upwards():
    world = World([(0, 0, 0, 0, 0, 8, 3, 0.05), (0, 1, 2.5, 0, 0.01, 8, 3, 0.05)])
    got = world.settle()
    assert world.worst(got) < 0.01
    assert (got[..., 2] == 0).all()
    assert float(got[0, 2, 1] - got[0, 1, 1]) == pytest.approx(3.0, abs=0.01)


def test_a_small_box_within_a_large_one_comes_out_at_the_near_side():
    world = World([(0, 0, 0, 0, 0, 6, 6, 3), (0, 2.0, 0.3, 0.4, 0, 0.5, 0.5, 1)])
    got = world.settle(n_hops=0)
    assert world.worst(got) < 0.01
    assert float(got[0, 2, 0]) > 3
    # The large one is heavy.
    assert (got[0, 1] - world.x0[0, 1]).norm() < 0.25 * (got[0, 2] - world.x0[0, 2]).norm()


def test_coarse_objects_give_way_less():
    rows = [(0, 0, 0, 0, 0, 1, 1, 1), (0, 0.5, 0, 0, 0, 1, 1, 1)]
    world = World(rows, n_coarse=2)
    moved = (world.settle() - world.x0)[0].norm(dim=-1)
    assert float(moved[2] / moved[1]) == pytest.approx(4, rel=0.05)


def test_children_move_with_their_parent_and_may_overlap_it():
    rows = [
        (0, 0, 0, 0.5, 0, 2, 2, 1),
        (1, 0.3, 0, 0.5, 1, 0.4, 0.4, 0.2),
        (0, 1.5, 0, 0, 0, 2, 2, 1),
    ]
    world = World(rows)
    got = world.settle()
    assert world.worst(got) < 0.01
    assert torch.equal(got[0, 2], world.x0[0, 2])
    assert not torch.allclose(got[0, 1], world.x0[0, 1], atol=0.05)


def test_what_is_in_two_houses_waits_until_they_have_parted():
    """The sofa stands in its house's wall-to-be; nothing is wrong with it once the houses part."""
    rows = [(0, 0, 0, 0, 0, 6, 6, 3), (1, 2.6, 0, 0, 0, 0.6, 2, 1), (0, 5, 0, 0, 0, 6, 6, 3)]
    world = World(rows, n_coarse=1)
    got = world.settle(patience=1.0)
    assert world.worst(got) < 0.01
    assert torch.equal(got[0, 2], world.x0[0, 2])


def test_nobody_is_pushed_over_the_border_of_its_kind():
    world = World([(0, 1.9, 0, 0, 0, 1, 1, 1), (0, 1.5, 0.1, 0, 0, 1, 1, 1)], border_m=2.0)
    got = world.settle()
    assert world.worst(got) < 0.01
    assert float(got.abs().max()) <= 2.0


def test_fixed_objects_stay_and_the_others_give_way():
    world = World([(0, 0, 0, 0, 0, 1, 1, 1), (0, 0.5, 0, 0, 0, 1, 1, 1)])
    fixed = torch.tensor([[False, True, False]])
    got = world.settle(replace(LAST, fixed=fixed))
    assert torch.equal(got[0, 1], world.x0[0, 1])
    assert world.worst(got) < 0.01


def test_a_chair_between_walls_too_near_hops_to_where_there_is_room():
    walls = [(0, -0.4, 0, 0, 0, 0.2, 3, 2), (0, 0.4, 0, 0, 0, 0.2, 3, 2)]
    world = World([*walls, (0, 0, 0, 0, 0, 0.9, 0.9, 1)], n_coarse=3)
    pinned = replace(LAST, fixed=torch.tensor([[False, True, True, False]]))
    world.batch = replace(world.batch, weight=world.batch.weight.clone())
    stuck = world.settle(pinned, n_hops=0, clip_m=1.2)
    assert world.worst(stuck) > 0.05
    free = world.settle(pinned, clip_m=5.0)
    assert world.worst(free) < 0.01
    assert float(free[0, 3].norm()) < 3


def test_what_no_push_can_free_stays_where_it_is():
    """A slab too low over a room as wide as its house: neither has anywhere to go."""
    room, slab = (0, 0.1, 0, 0, 0, 5, 5, 3), (0, 0, 0, 0, 2.8, 5, 5, 0.3)
    world = World([room, slab], n_coarse=3, border_m=0.5)
    assert torch.equal(world.settle(), world.x0)


def test_no_step_moves_an_object_farther_than_the_clip():
    world = World([(0, 0, 0, 0, 0, 6, 6, 3), (0, 0.2, 0.3, 0, 0, 6, 6, 3)])
    moved = (world.settle(LATE, clip_m=2.2) - world.x0)[..., :2]
    assert float(moved.abs().max()) == pytest.approx(2.2, abs=1e-5)


def test_guidance_is_late():
    world = World([(0, 0, 0, 0, 0, 1, 1, 1), (0, 0.5, 0, 0, 0, 1, 1, 1)])
    assert torch.equal(world.settle(EARLY), world.x0)
    assert not torch.equal(world.settle(LATE), world.x0)
    assert torch.equal(world.guidance().on_mean(world.x0, world.x0, world.batch, LATE), world.x0)


def test_scenes_of_a_batch_do_not_feel_each_other():
    rows = [(0, 0, 0, 0.3, 0, 1, 1, 1), (0, 0.5, 0.2, 0, 0, 1, 2, 1), (0, 0.4, 1, 0, 0, 1, 1, 1)]
    worlds = [World(rows), World([(*row[:1], row[1] * 0.7, *row[2:]) for row in rows])]
    alone = [world.settle(n_hops=0) for world in worlds]
    batch = worlds[0].batch
    both = replace(
        batch,
        **{
            name: torch.cat([getattr(world.batch, name) for world in worlds])
            for name in ("kind", "parent", "depth", "mask", "weight")
        },
    )
    decoded = [world.decode for world in worlds]

    def decode(x0, _):
        boxes = [one(x0[i : i + 1], worlds[i].batch) for i, one in enumerate(decoded)]
        fields = vars(boxes[0])
        return replace(
            boxes[0], **{name: torch.cat([getattr(b, name) for b in boxes]) for name in fields}
        )

    bounds = tuple(torch.cat([world.bounds[i] for world in worlds]) for i in range(2))
    guidance = SeparationGuidance(decode, lambda _: bounds, SeparationCfg(n_hops=0))
    got = guidance.on_x0(torch.cat([world.x0 for world in worlds]), both, LAST)
    assert torch.allclose(got, torch.cat(alone), atol=0.01)


@pytest.fixture(scope="module")
def corpus():
    """Tokens of an outdoor and an indoor corpus scene, and their decoder."""
    scenes = [cached_scene(7), cached_scene(311)]
    vocabulary = count_kinds(scenes)
    examples, statistics = encode_corpus(scenes, vocabulary)
    return Collator(vocabulary, statistics).examples(examples), TreeDecoder(vocabulary, statistics)


def _share_colliding(boxes, batch) -> float:
    above = lineage(batch)
    pairs = near_pairs(boxes, above | above.transpose(1, 2), 0.0)
    is_deep = overlap(pairs) > 0.01
    hit = torch.cat([pairs.first[is_deep], pairs.second[is_deep]]).unique()
    return len(hit) / (int(batch.mask.sum()) - len(batch.mask))


def test_corpus_scenes_are_left_as_they_are(corpus):
    batch, decoder = corpus
    assert _share_colliding(decoder.decode(batch.x0, batch), batch) == 0
    got = SeparationGuidance(decoder.decode, decoder.bounds).on_x0(batch.x0, batch, LAST)
    assert torch.equal(got, batch.x0)


@pytest.mark.parametrize(("jitter_m", "share"), [(0.3, 0.06), (1.0, 0.1)])
def test_jittered_corpus_scenes_come_nearly_free(corpus, jitter_m, share):
    batch, decoder = corpus
    play = decoder.decode(batch.x0, batch).play_m
    noise = torch.randn(play.shape, generator=torch.Generator().manual_seed(0))
    shift = jitter_m * noise / play * (batch.weight[..., :2] > 0)
    jittered = torch.cat([batch.x0[..., :2] + shift, batch.x0[..., 2:]], dim=-1)
    jittered = jittered.clamp(*decoder.bounds(batch))
    assert _share_colliding(decoder.decode(jittered, batch), batch) > 0.25
    guidance = SeparationGuidance(decoder.decode, decoder.bounds)
    got = guidance.on_x0(jittered, batch, LAST)
    assert _share_colliding(decoder.decode(got, batch), batch) < share
    # Nothing shrank or turned.
    assert torch.equal(got[..., 3:], jittered[..., 3:])
    assert torch.equal(guidance.on_x0(jittered, batch, LAST), got)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"late_share": 1.5}, "separation.late_share is 1.5, valid: 0 to 1"),
        ({"clip_m": -1.0}, "separation.clip_m is -1, valid: 0 to 100"),
        ({"coarse_mass": 0.0}, "separation.coarse_mass is 0, valid: 0.01 to 1000"),
    ],
)
def test_settings_out_of_range_say_what_is_valid(setting, message):
    with pytest.raises(DiffusionError) as error:
        SeparationCfg(**setting)
    assert str(error.value) == message
