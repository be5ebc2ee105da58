from dataclasses import replace

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from aeroscene.learning.guidance.contacts import near_pairs
from aeroscene.learning.guidance.pushing import (
    Movable,
    separate,
    separate_at_once,
    separate_in_loop,
)
from aeroscene.learning.guidance.tree import lineage, parent_heading
from aeroscene.learning.tokens.boxes import Boxes
from tests.aeroscene.learning.guidance.layouts import random_layout, world_batch

PARENT = [0, 0, 0, 0, 1, 1, 2, 4, 4, 3, 0, 6]


@pytest.fixture(autouse=True)
def _one_thread():
    torch.set_num_threads(1)


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


def _both(seed: int, n_steps: int, n_patient_steps: int) -> tuple[Tensor, Tensor]:
    boxes, movable = _crowd(seed)
    family = movable.lineage | movable.lineage.transpose(1, 2)
    pairs = near_pairs(boxes, family, 1.0)
    steps = (0.004, n_steps, n_patient_steps)
    return separate_in_loop(pairs, movable, *steps), separate_at_once(pairs, movable, *steps)


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.sampled_from([(1, 0), (7, 3), (20, 6)]))
def test_pairs_one_by_one_and_all_at_once_give_the_same_displacements(seed, steps):
    in_loop, at_once = _both(seed, *steps)
    assert at_once.abs().max() > 0.01
    assert torch.allclose(in_loop, at_once, atol=1e-9)


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
