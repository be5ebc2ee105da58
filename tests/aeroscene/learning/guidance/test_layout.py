import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.guidance.layout import flat_reader, heading_of_quaternion, tree_reader
from aeroscene.learning.paper.tokens import flat_training_set
from aeroscene.learning.tokens.batch import Collator
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.examples import encode_corpus
from aeroscene.learning.tokens.kinds import count_kinds
from aeroscene.learning.tokens.skeleton import token_order
from aeroscene.scene.box import quat_from_yaw, quat_product
from tests.aeroscene.conftest import cached_scene


def test_flat_layouts_are_read_as_the_boxes_that_were_written():
    scene = cached_scene(311)
    data = flat_training_set([scene])
    batch = data.in_order(0, 1)
    layout = flat_reader(data.statistics)(batch.x0, batch)
    for slot, obj in enumerate(token_order(scene)):
        assert layout.center_enu_m[0, slot].tolist() == pytest.approx(obj.bbox.p, abs=1e-3)
        assert layout.size_m[0, slot].tolist() == pytest.approx(obj.bbox.s, abs=1e-3)
        yaw = torch.tensor(obj.bbox.yaw_rad)
        expected = [float(yaw.cos()), float(yaw.sin())]
        assert layout.heading[0, slot].tolist() == pytest.approx(expected, abs=1e-4)
        assert int(layout.category[0, slot].argmax()) == obj.category_id - 1
        assert bool(layout.is_coarse[slot]) == obj.is_coarse
    assert int(layout.mask.sum()) == len(scene.objects)


def test_tree_layouts_leave_the_site_out():
    scene = cached_scene(311)
    vocabulary = count_kinds([scene])
    examples, statistics = encode_corpus([scene], vocabulary)
    batch = Collator(vocabulary, statistics).examples(examples)
    read = tree_reader(TreeDecoder(vocabulary, statistics), vocabulary.n_kinds)
    x0 = batch.x0.clone().requires_grad_()
    layout = read(x0, batch)
    assert int(layout.mask.sum()) == len(scene.objects)
    assert not layout.mask[0, 0]
    last = layout.center_enu_m[0, -1]
    expected = token_order(scene)[-1].bbox.p
    assert last.tolist() == pytest.approx(expected, abs=1e-3)
    (slope,) = torch.autograd.grad(last.sum(), x0)
    assert (slope != 0).any()


@given(st.floats(-3, 3), st.floats(0.1, 10))
def test_heading_of_a_quaternion_is_its_yaw_at_any_norm(yaw, norm):
    quat = norm * torch.tensor(quat_from_yaw(yaw), dtype=torch.float64)
    angle = torch.tensor(yaw, dtype=torch.float64)
    expected = [float(angle.cos()), float(angle.sin())]
    assert heading_of_quaternion(quat).tolist() == pytest.approx(expected, abs=1e-6)


@given(st.floats(-3, 3), st.floats(-1, 1))
def test_a_roll_does_not_turn_the_heading(yaw, roll):
    half = torch.tensor(roll / 2, dtype=torch.float64)
    tilted = quat_product(quat_from_yaw(yaw), (float(half.cos()), float(half.sin()), 0.0, 0.0))
    upright = heading_of_quaternion(torch.tensor(quat_from_yaw(yaw), dtype=torch.float64))
    got = heading_of_quaternion(torch.tensor(tilted, dtype=torch.float64))
    assert torch.allclose(got, upright, atol=1e-6)
