import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.guidance.layout import FlatReader, turn_back, turn_on
from aeroscene.learning.paper.training_set import flat_training_set
from tests.aeroscene.conftest import cached_scene


@given(st.floats(-3, 3), st.floats(-2, 2), st.floats(-2, 2))
def test_turning_back_undoes_the_heading(yaw, x, y):
    turned = torch.tensor(yaw, dtype=torch.float64)
    heading = torch.stack([turned.cos(), turned.sin()])
    ahead = torch.tensor([x, y], dtype=torch.float64)
    away = torch.cat([turn_on(ahead, heading), ahead.new_tensor([1.0])])
    back = turn_back(away, heading)
    assert back.tolist() == pytest.approx([x, y, 1.0], abs=1e-9)


@pytest.mark.parametrize("has_regions", [False, True])
def test_a_step_of_one_in_a_position_channel_is_as_many_metres_as_it_says(has_regions):
    data = flat_training_set([cached_scene(311)], has_regions=has_regions)
    batch, read = data.in_order(0, 1), FlatReader(data.statistics)
    free = batch.mask & ~batch.given
    for channel in range(3):
        moved = batch.x0.double().clone()
        moved[..., channel] += 1
        way_m = read(moved, batch).center_enu_m - read(batch.x0.double(), batch).center_enu_m
        found, expected = way_m.norm(dim=-1)[free], read.metres_of(batch)[..., channel][free]
        np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_the_quaternion_may_have_any_norm_and_sizes_any_value():
    data = flat_training_set([cached_scene(311)])
    batch, read = data.in_order(0, 1), FlatReader(data.statistics)
    layout = read(1e6 * torch.ones_like(batch.x0), batch)
    for value in (layout.center_enu_m, layout.size_m, layout.heading):
        assert value.isfinite().all()
    assert layout.size_m.max() < 301
