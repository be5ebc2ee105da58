"""A* finds the optimum that Dijkstra finds, and says when there is no path."""

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from autonomy.planning import DistanceField, UnreachableError
from autonomy.planning.search import NARROWNESS_PRICE, SeenRoom, search_grid, shortest_path
from tests.autonomy.planning_worlds import seeds

REQUIRED, COMFORTABLE = 0.5, 2.0
STEPS = [step for step in product((-1, 0, 1), repeat=3) if any(step)]


def random_field(rng):
    """Random distances: to the search any numbers will do."""
    distance = rng.uniform(0.0, 3.0, rng.integers(3, 7, 3))
    distance[rng.uniform(size=distance.shape) < 0.15] = 0.0
    return DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1.0, distance_m=distance)


def price(field, cell):
    lack = np.clip((COMFORTABLE - field.distance_m[cell]) / (COMFORTABLE - REQUIRED), 0, 1)
    return 1.0 + NARROWNESS_PRICE * lack**2


def step_cost(field, a, b):
    """Cost of a step between neighbours; None if it is blocked."""
    block = tuple(slice(min(i, j), max(i, j) + 1) for i, j in zip(a, b, strict=True))
    if field.distance_m[block].min() < REQUIRED:
        return None
    return np.linalg.norm(np.subtract(a, b)) * (price(field, a) + price(field, b)) / 2


def optimum(field, start, goal):
    """By scipy, over all cells and steps."""
    shape = field.distance_m.shape
    rows, columns, costs = [], [], []
    for a in np.ndindex(shape):
        for step in STEPS:
            b = tuple(np.add(a, step))
            if all(0 <= i < n for i, n in zip(b, shape, strict=True)):
                cost = step_cost(field, a, b)
                if cost is not None:
                    rows.append(np.ravel_multi_index(a, shape))
                    columns.append(np.ravel_multi_index(b, shape))
                    costs.append(cost)
    graph = csr_array((costs, (rows, columns)), shape=(field.distance_m.size,) * 2)
    at_start = np.ravel_multi_index(start, shape)
    return dijkstra(graph, indices=at_start)[np.ravel_multi_index(goal, shape)]


@given(seeds)
@settings(max_examples=25)
def test_path_costs_as_much_as_dijkstras_optimum(seed):
    rng = np.random.default_rng(seed)
    field = random_field(rng)
    free = np.argwhere(field.distance_m >= REQUIRED)
    start, goal = free[rng.integers(0, len(free), 2)]
    best = optimum(field, tuple(start), tuple(goal))
    try:
        path = shortest_path(field, start, goal, required_m=REQUIRED, comfortable_m=COMFORTABLE)
    except UnreachableError:
        assert best == np.inf
        return
    np.testing.assert_array_equal(path[[0, -1]], [start, goal])
    steps = [step_cost(field, tuple(a), tuple(b)) for a, b in pairwise(path)]
    assert None not in steps
    assert sum(steps) == pytest.approx(best, rel=1e-5)


def test_diagonal_steps_cut_no_corner():
    distance = np.full((2, 2, 1), 3.0)
    distance[0, 1, 0] = 0.0
    field = DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1.0, distance_m=distance)
    path = shortest_path(
        field, np.array([0, 0, 0]), np.array([1, 1, 0]), required_m=1.0, comfortable_m=2.0
    )
    assert path.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]


def test_a_wall_without_a_gap_is_named_unreachable():
    distance = np.full((9, 5, 5), 3.0)
    distance[4] = 0.2
    field = DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1.0, distance_m=distance)
    with pytest.raises(UnreachableError, match=r"needs 0\.50 m"):
        shortest_path(
            field, np.array([0, 2, 2]), np.array([8, 2, 2]), required_m=0.5, comfortable_m=2.0
        )


def test_the_narrowest_place_of_the_widest_way_is_named():
    distance = np.full((9, 5, 5), 3.0)
    distance[4] = 0.2
    distance[4, 2, 3], distance[4, 1, 1] = 0.3, 0.4
    field = DistanceField(origin_enu_m=(0, 0, 0), resolution_m=0.5, distance_m=distance)
    with pytest.raises(UnreachableError, match=r"has 0\.40 m at \(2\.0, 0\.5, 0\.5\) m"):
        shortest_path(
            field, np.array([0, 2, 2]), np.array([8, 2, 2]), required_m=0.5, comfortable_m=2.0
        )


def test_an_end_without_room_is_unreachable_whatever_the_way():
    distance = np.full((9, 5, 5), 3.0)
    distance[0, 2, 2] = 0.1
    field = DistanceField(origin_enu_m=(0, 0, 0), resolution_m=0.5, distance_m=distance)
    ends = np.array([0, 2, 2]), np.array([8, 2, 2])
    for start, goal in (ends, ends[::-1]):
        with pytest.raises(UnreachableError, match=r"widest way has 3\.00 m"):
            shortest_path(field, start, goal, required_m=0.5, comfortable_m=2.0)


def test_a_search_begins_in_the_narrow(monkeypatch):
    distance = np.full((120, 120, 30), 3.0)
    distance[50:61, 50:61, :8] = 0.0
    distance[51:60, 51:60, 1:7] = 1.0
    distance[50, 53:58, 1:5] = 1.0
    field = DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1.0, distance_m=distance)
    outside, inside = np.array([110, 10, 20]), np.array([58, 58, 3])
    n_met = []

    def counting(*arguments):
        path = search_grid(*arguments)
        n_met.append(np.count_nonzero(arguments[-1]))
        return path

    monkeypatch.setattr("autonomy.planning.search.search_grid", counting)
    paths = [
        shortest_path(field, start, goal, required_m=0.9, comfortable_m=2.0)
        for start, goal in ((inside, outside), (outside, inside))
    ]
    np.testing.assert_array_equal(paths[0], paths[1][::-1])
    assert max(n_met) < 20_000


def test_climbing_unseen_is_put_off_until_it_can_be_seen():
    distance = np.full((30, 3, 12), 3.0)
    field = DistanceField(origin_enu_m=(0, 0, 0), resolution_m=1.0, distance_m=distance)
    is_seen = np.zeros(distance.shape, dtype=bool)
    is_seen[10:14] = True
    start, goal = np.array([0, 1, 1]), np.array([29, 1, 9])

    def path_between(a, b, seen=None):
        return shortest_path(
            field, a, b, required_m=0.5, comfortable_m=2.0, seen=seen, climb_price=4.0
        )

    seen = SeenRoom(is_seen.astype(np.float32), 1.0, 11)
    path = path_between(start, goal, seen)
    rises = path[1:][np.diff(path[:, 2]) > 0]
    seen_rises = is_seen[tuple(rises.T)].sum()
    straight = path_between(start, goal)
    assert len(straight) == 30
    assert seen_rises > is_seen[tuple(straight[1:][np.diff(straight[:, 2]) > 0].T)].sum()
    down = path_between(goal, start, seen)
    assert len(down) == 30
