from dataclasses import replace

import pytest
import torch

from aeroscene.learning.paper.guidance.collision import collision_loss
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.overlap import iou
from tests.aeroscene.learning.guidance.layouts import random_layout


@pytest.mark.parametrize("tolerance", [0.0, 0.01, 0.1])
def test_exact_loss_sums_every_ordered_pair(tolerance):
    layout = random_layout(0)
    expected = []
    for scene in range(2):
        rows = [
            OrientedBox(
                tuple(layout.center_enu_m[scene, i].tolist()),
                quat_from_yaw(float(torch.atan2(*layout.heading[scene, i].flip(0)))),
                tuple(layout.size_m[scene, i].tolist()),
            )
            for i in range(11)  # the last slot is padding
        ]
        pairs = [(a, b) for a in rows for b in rows if a is not b]
        expected.append(sum(max(0.0, iou(a, b) - tolerance) for a, b in pairs))
    loss = collision_loss(layout, tolerance=tolerance, kind="exact", softness_m=0.1)
    assert loss.tolist() == pytest.approx(expected, abs=1e-3)
    assert min(expected) > 0.1


def test_objects_far_apart_cost_nothing():
    layout = random_layout(1)
    far = replace(layout, center_enu_m=layout.center_enu_m * 100)
    for kind in ("exact", "soft"):
        loss = collision_loss(far, tolerance=0.01, kind=kind, softness_m=0.1)
        assert loss.tolist() == [0, 0]


@pytest.mark.parametrize("kind", ["exact", "soft"])
def test_following_the_gradient_parts_two_boxes(kind):
    layout = random_layout(2, n=3, n_coarse=1)
    center = torch.zeros(2, 3, 3, dtype=torch.float64)
    center[:, 1, 0] = 0.9
    heading = torch.tensor([1.0, 0.0], dtype=torch.float64).expand(2, 3, 2)
    for _ in range(200):
        center = center.detach().requires_grad_()
        moved = replace(
            layout, center_enu_m=center, heading=heading, size_m=torch.ones_like(center)
        )
        loss = collision_loss(moved, tolerance=0.01, kind=kind, softness_m=0.02).sum()
        if float(loss.detach()) == 0:
            break
        (gradient,) = torch.autograd.grad(loss, center)
        center = center - 0.01 * gradient
    assert float(loss.detach()) == 0
    apart = (center[:, 1] - center[:, 0]).norm(dim=-1)
    assert ((apart > 0.97) & (apart < 1.2)).all()
