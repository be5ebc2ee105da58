from dataclasses import replace

import pytest
import torch

from aeroscene.learning.paper.guidance.coarse_to_fine import coarse_to_fine_loss
from aeroscene.scene.box import quat_from_yaw
from tests.aeroscene.learning.guidance.layouts import random_layout
from tests.aeroscene.scene.points import signed_distance


def test_paper_form_sums_distances_to_the_nearest_coarse_centre():
    layout = random_layout(0)
    expected = []
    for scene in range(2):
        center = layout.center_enu_m[scene]
        away = [min(float((center[i] - center[j]).norm()) for j in range(4)) for i in range(4, 11)]
        expected.append(sum(away))
    assert coarse_to_fine_loss(layout, "centroid").tolist() == pytest.approx(expected)


def test_hinge_measures_the_distance_to_the_footprint_only():
    layout = random_layout(0)
    spread = replace(layout, center_enu_m=layout.center_enu_m * 3)
    expected = []
    for scene in range(2):
        center, size = spread.center_enu_m[scene], spread.size_m[scene]
        total = 0.0
        for i in range(4, 11):
            j = int((center[:4] - center[i]).norm(dim=-1).argmin())
            yaw = float(torch.atan2(*spread.heading[scene, j].flip(0)))
            # Above each other: as far away as their footprints.
            tall = [*size[j, :2].tolist(), 1000.0]
            outside = signed_distance(
                center[i].tolist(), center[j].tolist(), quat_from_yaw(yaw), tall
            )
            total += max(0.0, float(outside))
        expected.append(total)
    assert coarse_to_fine_loss(spread, "border").tolist() == pytest.approx(expected, abs=1e-6)
    assert min(expected) > 0


def test_hinge_leaves_what_is_within_its_region_where_it_is():
    layout = random_layout(0)
    size = torch.full_like(layout.size_m, 100.0)
    center = layout.center_enu_m.clone().requires_grad_()
    within = replace(layout, center_enu_m=center, size_m=size)
    loss = coarse_to_fine_loss(within, "border").sum()
    (gradient,) = torch.autograd.grad(loss, center)
    assert float(loss.detach()) == 0
    assert (gradient == 0).all()
    (pull,) = torch.autograd.grad(coarse_to_fine_loss(within, "centroid").sum(), center)
    assert (pull[:, 4:11].norm(dim=-1) > 0.99).all()


def test_without_coarse_objects_there_is_no_region():
    layout = replace(random_layout(0), is_coarse=torch.zeros(12, dtype=torch.bool))
    assert coarse_to_fine_loss(layout, "centroid").tolist() == [0, 0]
