from dataclasses import replace

import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from aeroscene.learning.guidance.contacts import near_pairs, overlap
from aeroscene.learning.guidance.pushing import Movable, separate
from aeroscene.learning.guidance.tree import lineage, parent_heading
from aeroscene.learning.tokens.boxes import Boxes
from tests.aeroscene.learning.guidance.layouts import random_layout, world_batch

PARENT = [0, 0, 0, 0, 1, 1, 2, 4, 4, 3, 0, 6]


def _crowd(seed: int) -> tuple[Boxes, Movable]:
    """Two scenes of turned boxes that overlap, some of which stand on others."""
    layout = random_layout(seed, n=len(PARENT))
    one = world_batch(PARENT, 4)
    batch = replace(one, parent=one.parent.expand(2, -1), depth=one.depth.expand(2, -1))
    boxes = Boxes(
        layout.center_enu_m,
        layout.heading,
        layout.size_m,
        torch.ones(2, len(PARENT), 2),
        torch.ones(2, len(PARENT)),
        torch.zeros(2, len(PARENT), 7),
        layout.mask,
    )
    generator = torch.Generator().manual_seed(seed)
    room = torch.rand(2, *layout.center_enu_m.shape, generator=generator, dtype=torch.float64)
    room[..., 2] *= torch.rand(len(PARENT), generator=generator) < 0.3
    movable = Movable(
        heading=parent_heading(boxes.heading, batch),
        low_m=-2 * room[0],
        high_m=2 * room[1],
        lightness=1 / (0.3 + boxes.size_m.prod(-1)),
        lineage=lineage(batch),
        parent=batch.parent,
    )
    return boxes, movable


def _pair(lightness: tuple[float, float], high_m: float = 5.0) -> Tensor:
    """Displacements of two cubes that overlap by 0.2 m, and of one that the second carries."""
    center = torch.tensor([[[0.0, 0.0, 0.0], [0.8, 0.1, 0.0], [0.8, 0.1, 5.0]]]).double()
    n = center.shape[1]
    boxes = Boxes(
        center,
        torch.tensor([1.0, 0.0]).double().expand(1, n, 2),
        torch.ones(1, n, 3).double(),
        torch.ones(1, n, 2),
        torch.ones(1, n),
        torch.zeros(1, n, 7),
        torch.ones(1, n, dtype=torch.bool),
    )
    above = torch.eye(n, dtype=torch.bool)[None].clone()
    above[0, 2, 1] = True
    movable = Movable(
        heading=boxes.heading,
        low_m=torch.full((1, n, 3), -5.0).double(),
        high_m=torch.full((1, n, 3), high_m).double(),
        lightness=torch.tensor([[*lightness, 1.0]]).double(),
        lineage=above,
        parent=torch.tensor([[0, 1, 1]]),
    )
    moved = separate(boxes, movable, tolerance_m=0.002, margin_m=1.0, n_steps=20)
    return movable.move(boxes, moved).center_enu_m[0] - center[0]


def test_two_that_overlap_part_along_the_shortest_way_in_proportion_to_their_lightness():
    expected = torch.tensor([[-0.1, 0, 0], [0.1, 0, 0], [0.1, 0, 0]]).double()
    assert torch.allclose(_pair((1.0, 1.0)), expected, atol=0.001)
    expected = torch.tensor([[-0.15, 0, 0], [0.05, 0, 0], [0.05, 0, 0]]).double()
    assert torch.allclose(_pair((3.0, 1.0)), expected, atol=0.001)


def test_what_one_cannot_give_way_the_other_does():
    assert torch.allclose(
        _pair((1.0, 1.0), high_m=0.0)[:, 0].abs().amax(), torch.tensor(0.2).double(), atol=0.001
    )


@settings(max_examples=25)
@given(st.integers(0, 10_000))
def test_most_of_what_overlaps_comes_apart(seed):
    boxes, movable = _crowd(seed)
    family = movable.lineage | movable.lineage.transpose(1, 2)
    free = replace(movable, low_m=0 * movable.low_m - 9, high_m=0 * movable.high_m + 9)
    moved = separate(boxes, free, tolerance_m=0.004, margin_m=1.0, n_steps=60, n_patient_steps=9)
    before, after = (
        overlap(near_pairs(each, family, 0.0)).clamp(min=0).sum()
        for each in (boxes, free.move(boxes, moved))
    )
    assert after < 0.2 * before


@settings(max_examples=10)
@given(st.integers(0, 10_000))
def test_nothing_leaves_its_bounds(seed):
    boxes, movable = _crowd(seed)
    moved = separate(boxes, movable, tolerance_m=0.004, margin_m=1.0, n_steps=20)
    assert (moved >= movable.low_m).all()
    assert (moved <= movable.high_m).all()


def test_scenes_of_a_batch_do_not_touch_each_other():
    boxes, movable = _crowd(3)
    settings_of = {"tolerance_m": 0.004, "margin_m": 1.0, "n_steps": 12, "n_patient_steps": 4}
    both = separate(boxes, movable, **settings_of)
    names = ("center_enu_m", "heading", "size_m", "play_m", "rise_m", "openings_m", "mask")
    for row in (0, 1):
        some = slice(row, row + 1)
        alone = Boxes(*(getattr(boxes, name)[some] for name in names))
        names_of = ("heading", "low_m", "high_m", "lightness", "lineage", "parent")
        free = Movable(**{name: getattr(movable, name)[some] for name in names_of})
        assert torch.equal(separate(alone, free, **settings_of)[0], both[row])
