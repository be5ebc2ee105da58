import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.guidance.layout import flat_reader, heading_of_quaternion, turn_back
from aeroscene.learning.paper.tokens import flat_training_set
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


@given(st.floats(-3, 3), st.floats(-2, 2), st.floats(-2, 2))
def test_turning_back_undoes_the_heading(yaw, x, y):
    turned = torch.tensor(yaw, dtype=torch.float64)
    heading = torch.stack([turned.cos(), turned.sin()])
    ahead = torch.tensor([x, y, 1.0], dtype=torch.float64)
    away = torch.stack(
        [
            heading[0] * x - heading[1] * y,
            heading[1] * x + heading[0] * y,
            ahead.new_tensor(1.0),
        ]
    )
    assert torch.allclose(turn_back(away, heading), ahead, atol=1e-9)
