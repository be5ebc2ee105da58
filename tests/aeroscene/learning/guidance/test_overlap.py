import math

import pytest
import shapely
import torch
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.paper.guidance.overlap import (
    BoxPairs,
    exact_iou,
    footprint_intersection,
    penetration_m,
    soft_iou,
)
from aeroscene.scene import OrientedBox
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.overlap import iou

extent = st.floats(0.05, 6)
boxes = st.tuples(
    st.floats(-3, 3), st.floats(-3, 3), st.floats(-1, 1), st.floats(-4, 4), extent, extent, extent
)


def _pairs(first: tuple, second: tuple) -> BoxPairs:
    rows = torch.tensor([[first], [second]], dtype=torch.float64)
    yaw = rows[..., 3]
    heading = torch.stack([yaw.cos(), yaw.sin()], dim=-1)
    return BoxPairs(
        (rows[0, :, :3], rows[1, :, :3]), (heading[0], heading[1]), (rows[0, :, 4:], rows[1, :, 4:])
    )


def _rectangle(box: tuple) -> shapely.Polygon:
    x, y, _, yaw, a, b, _ = box
    outline = shapely.box(-a / 2, -b / 2, a / 2, b / 2)
    turned = shapely.affinity.rotate(outline, yaw, origin=(0, 0), use_radians=True)
    return shapely.affinity.translate(turned, x, y)


@given(boxes, boxes)
def test_footprints_share_what_shapely_says(first, second):
    expected = _rectangle(first).intersection(_rectangle(second)).area
    got = float(footprint_intersection(_pairs(first, second)))
    assert got == pytest.approx(expected, abs=1e-4)


@given(boxes, boxes)
def test_exact_iou_is_that_of_the_geometry_module(first, second):
    oriented = [OrientedBox(b[:3], quat_from_yaw(b[3]), b[4:]) for b in (first, second)]
    got = float(exact_iou(_pairs(first, second)))
    assert got == pytest.approx(iou(*oriented), abs=1e-4)


@given(boxes)
def test_a_box_with_itself_has_iou_one(box):
    assert float(exact_iou(_pairs(box, box))) == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("quarters", range(4))
def test_touching_boxes_share_nothing(quarters):
    yaw = quarters * math.pi / 2
    pairs = _pairs((0, 0, 0, 0, 2, 2, 1), (2, 0, 0, yaw, 2, 2, 1))
    assert float(exact_iou(pairs)) == pytest.approx(0, abs=1e-6)


@given(boxes, boxes)
def test_soft_iou_of_parallel_boxes_goes_to_the_exact_one(first, second):
    parallel = (*second[:3], first[3], *second[4:])
    pairs = _pairs(first, parallel)
    assert float(soft_iou(pairs, 1e-5)) == pytest.approx(float(exact_iou(pairs)), abs=2e-3)


@given(boxes, boxes)
def test_soft_iou_is_no_smaller_than_the_exact_one(first, second):
    pairs = _pairs(first, second)
    assert float(soft_iou(pairs, 1e-5)) >= float(exact_iou(pairs)) - 2e-3


def test_soft_iou_pulls_apart_what_the_exact_one_leaves():
    """One box in another, off the middle."""
    first, second = (0, 0, 0, 0, 4, 4, 1), (0.5, 0, 0, 0, 1, 1, 1)

    def slope(kind) -> float:
        pairs = _pairs(first, second)
        center = pairs.center_m[1].clone().requires_grad_()
        moved = BoxPairs((pairs.center_m[0], center), pairs.heading, pairs.size_m)
        (gradient,) = torch.autograd.grad(kind(moved).sum(), center)
        return float(gradient[0, 0])

    assert slope(exact_iou) == pytest.approx(0, abs=1e-9)
    assert slope(lambda pairs: soft_iou(pairs, 0.5)) < -1e-4


@pytest.mark.parametrize("kind", [exact_iou, lambda pairs: soft_iou(pairs, 0.2)])
def test_gradients_are_those_of_finite_differences(kind):
    generator = torch.Generator().manual_seed(3)
    for _ in range(20):
        rows = torch.rand(2, 1, 7, generator=generator, dtype=torch.float64)
        rows[..., :3] *= 1.5
        rows[..., 3] *= 3
        rows[..., 4:] += 0.8

        def value(flat):
            rows = flat.reshape(2, 1, 7)
            yaw = rows[..., 3]
            heading = torch.stack([yaw.cos(), yaw.sin()], dim=-1)
            return kind(
                BoxPairs(
                    (rows[0, :, :3], rows[1, :, :3]),
                    (heading[0], heading[1]),
                    (rows[0, :, 4:], rows[1, :, 4:]),
                )
            ).sum()

        _check_gradient(value, rows.flatten())


def _check_gradient(value, flat: torch.Tensor) -> None:
    flat = flat.clone().requires_grad_()
    (gradient,) = torch.autograd.grad(value(flat), flat)
    step = 1e-6
    with torch.no_grad():
        for index in range(len(flat)):
            nudge = torch.zeros_like(flat)
            nudge[index] = step
            slope = (value(flat + nudge) - value(flat - nudge)) / (2 * step)
            assert float(gradient[index]) == pytest.approx(float(slope), abs=1e-5)


def test_penetration_is_the_least_way_apart():
    """A wall of 0.2 m all within a bed: out through its nearer side, thick or thin."""
    for center, size, expected in (
        ((0.0, 0.5, 0.0), (4.0, 0.2, 2.0), 0.6),
        ((0.0, 0.0, 0.9), (4.0, 4.0, 0.2), 0.2),
        ((3.0, 0.0, 0.0), (4.0, 0.2, 2.0), 0.0),
        ((3.5, 0.0, 0.0), (4.0, 0.2, 2.0), -0.5),
    ):
        pairs = BoxPairs(
            (torch.zeros(1, 3), torch.tensor([center])),
            (torch.tensor([[1.0, 0.0]]), torch.tensor([[1.0, 0.0]])),
            (torch.tensor([[2.0, 2.0, 2.0]]), torch.tensor([size])),
        )
        assert float(penetration_m(pairs)) == pytest.approx(expected, abs=1e-3)
