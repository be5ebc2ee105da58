import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.guidance.tree import lineage, parent_heading, turn, turn_back
from tests.aeroscene.learning.diffusion.layouts import blank_batch
from tests.aeroscene.learning.guidance.layouts import world_batch


@given(st.lists(st.integers(0, 100), min_size=1, max_size=12))
def test_lineage_holds_all_ancestors_and_the_token_itself(numbers):
    parent = [0, *(number % (i + 1) for i, number in enumerate(numbers))]
    above = lineage(world_batch(parent, 1))[0]
    for i in range(len(parent)):
        line, place = {i}, i
        while place:
            place = parent[place]
            line.add(place)
        assert set(above[i].nonzero().flatten().tolist()) == line


def test_flat_layouts_have_no_lineage_and_the_axes_of_the_world():
    batch = blank_batch(2, 5, 3)
    batch.depth[:] = 0
    assert torch.equal(lineage(batch), torch.eye(5, dtype=torch.bool).expand(2, 5, 5))
    heading = torch.tensor([0.0, 1.0]).expand(2, 5, 2)
    assert torch.equal(parent_heading(heading, batch), torch.tensor([1.0, 0.0]).expand(2, 5, 2))


@given(st.floats(-7, 7), st.lists(st.floats(-5, 5), min_size=3, max_size=3))
def test_turning_back_undoes_turning(yaw, vector):
    angle = torch.tensor(yaw, dtype=torch.float64)
    heading = torch.stack([angle.cos(), angle.sin()])
    there = torch.tensor(vector, dtype=torch.float64)
    assert torch.allclose(turn_back(turn(there, heading), heading), there, atol=1e-12)
    assert torch.allclose(turn(torch.tensor([1.0, 0, 0]).double(), heading)[:2], heading)
