"""Judge of a recorded flight by pose, polygon and distances alone.

The first judge sees contacts of the physics engine. This one computes gaps between hull and solids
anew, with other code, so that a fault in one of them shows as a contradiction. A value within the
accuracy of the recording gives no answer rather than a wrong one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from shapely import Polygon, contains_xy, points

from judging.recording import Recording

_TOUCH_M, _FREE_M = 0.002, 0.015
"""Gaps up to which the vehicle touches, and from which it surely does not.

Between them there is no answer, because solids are soft, and the hull is known by points.
"""
_NEAR_M = 0.05  # distances beyond this do not matter
# Time over which the speed of touchdown is taken, and time at both ends of a flight that is spared
# by the least distance.
_IMPACT_S, _END_S = 0.02, 1.0


@dataclass(frozen=True)
class Finding:
    """One question about a flight, what was measured, and the answer.

    Attributes:
        question: The question, so that yes is good.
        value: Measured value; None for a question without one.
        holds: Answer; None if it is too close to tell.
    """

    question: str
    value: float | None
    holds: bool | None


@dataclass(frozen=True)
class Opinion:
    """Judgement of a flight."""

    findings: tuple[Finding, ...]
    least_distance_m: float
    """Least distance to every solid and the ground, m; what is farther than 5 cm counts as 5 cm.

    It is taken from a second after lift-off to a second before touchdown.
    """
    nearest: str
    """Entity of that solid."""

    @property
    def success(self) -> bool | None:
        """True if every question has the answer yes, false if one has no; else None."""
        answers = {finding.holds for finding in self.findings}
        return False if False in answers else None if None in answers else True

    @property
    def objections(self) -> list[str]:
        """Questions whose answer is no."""
        return [finding.question for finding in self.findings if finding.holds is False]


def judge_recording(flight: Recording) -> Opinion:
    """Judge a flight that was to end on an area.

    Args:
        flight: Recording.

    Raises:
        ValueError: If the flight has no area.
    """
    gap_m, nearest = _gaps(flight)
    lift_off, touchdown = _bounds(flight, gap_m)
    findings: list[Finding] = [_no("left the ground", lift_off is not None)]
    if lift_off is not None:
        findings += _on_the_way(gap_m[lift_off:touchdown])
    findings += _at_the_end(flight, gap_m[-1])
    if touchdown is not None:
        findings += _at_touchdown(flight, touchdown)
    least = _least(flight.time_s, gap_m, lift_off, touchdown)
    return Opinion(tuple(findings), float(gap_m[least]), nearest[least])


def _least(
    time_s: np.ndarray, gap_m: np.ndarray, lift_off: int | None, touchdown: int | None
) -> int:
    """Row of the least distance, away from both ends of the flight."""
    begin_s = time_s[lift_off or 0] + _END_S
    end_s = time_s[len(gap_m) - 1 if touchdown is None else touchdown] - _END_S
    between = (time_s >= begin_s) & (time_s <= end_s)
    return int(np.argmin(np.where(between, gap_m, np.inf)))


def _gaps(flight: Recording) -> tuple[np.ndarray, list[str]]:
    """Least distance from what stands, for each row, where it is small, and what is near."""
    # Farther from the vehicle's middle than this, no part of the hull is near.
    reach_m = float(np.linalg.norm(flight.hull_flu_m, axis=1).max() + _NEAR_M)
    gap_m, nearest = np.full(len(flight.time_s), _NEAR_M), np.full(len(flight.time_s), -1)
    turns = flight.attitude.as_matrix()

    def take(rows: np.ndarray, number: int) -> None:
        # In parts, because a hull has many points and a flight many rows.
        for some in np.array_split(rows, max(1, len(rows) // 500)):
            hull_m = flight.position_enu_m[some, None] + np.einsum(
                "nij,kj->nki", turns[some], flight.hull_flu_m
            )
            flat_m = hull_m.reshape(-1, 3)
            # The number -1 is the ground, whose distance is the height.
            far_m = flat_m[:, 2] if number < 0 else flight.solids[number].distances(flat_m)
            least_m = (far_m.reshape(hull_m.shape[:2]) - flight.hull_radius_m).min(axis=1)
            is_less = least_m < gap_m[some]
            gap_m[some[is_less]], nearest[some[is_less]] = least_m[is_less], number

    take(np.flatnonzero(flight.position_enu_m[:, 2] < reach_m), -1)
    for number, solid in enumerate(flight.solids):
        # Distances of the middle alone tell which rows to look at closely.
        rows = np.flatnonzero(solid.distances(flight.position_enu_m) < reach_m)
        if len(rows):
            take(rows, number)
    names = ["ground" if n < 0 else flight.solids[n].entity for n in nearest]
    return gap_m, names


def _bounds(flight: Recording, gap_m: np.ndarray) -> tuple[int | None, int | None]:
    """Rows of lift-off and touchdown; None for one that never happened."""
    # Changes between air and ground come in pairs, because ground stands before and after.
    edges = np.flatnonzero(np.diff(np.concatenate([[False], gap_m > _TOUCH_M, [False]])))
    runs = [slice(*pair) for pair in edges.reshape(-1, 2).tolist()]
    least_s = flight.limits["lift_off_s"]
    time_s = flight.time_s
    # Hops shorter than the limit are no flight.
    runs = [run for run in runs if time_s[run.stop - 1] - time_s[run.start] >= least_s]
    if not runs:
        return None, None
    lift_off, last = runs[0].start, runs[-1].stop
    rows = np.flatnonzero(gap_m[lift_off:] <= _TOUCH_M) + lift_off
    # Touching the area ends a flight, even where the vehicle bounces afterwards.
    on_area = rows[[_soles_inside(flight, row).any() for row in rows]] if len(rows) else rows
    if len(on_area):
        return lift_off, int(on_area[0])
    return lift_off, last if last < len(gap_m) else None


def _on_the_way(gap_m: np.ndarray) -> Iterator[Finding]:
    """Hold that nothing was touched on the way.

    The first and last rows are of the ground that is left and met.
    """
    least_m = float(gap_m[3:-3].min(initial=math.inf))
    holds = True if least_m > _TOUCH_M else False if least_m < -_TOUCH_M else None
    yield Finding("touched nothing before touchdown", least_m, holds)


def _at_the_end(flight: Recording, gap_m: float) -> Iterator[Finding]:
    limits, last = flight.limits, flight.time_s > flight.time_s[-1] - flight.limits["rest_s"]
    inside = _soles_inside(flight, len(flight.time_s) - 1)
    edge_m = _edge_m(flight)
    yield Finding(
        "came down", gap_m, None if _TOUCH_M < gap_m < _FREE_M else bool(gap_m <= _TOUCH_M)
    )
    # Recorded positions and polygons are accurate to millimetres.
    is_close = abs(edge_m) < 0.005
    yield Finding("all soles inside", edge_m, None if is_close else bool(inside.all()))
    up = flight.attitude[-1].as_matrix()[2, 2]
    tilt_deg = math.degrees(math.acos(min(1.0, up)))
    yield _at_most("upright", tilt_deg, limits["tilt_deg"], 0.1)
    places_m, time_s = flight.position_enu_m[last], flight.time_s[last]
    # Differences over 20 ms: positions have single precision.
    speed_mps = np.linalg.norm(places_m[5:] - places_m[:-5], axis=1) / (time_s[5:] - time_s[:-5])
    yield _at_most("at rest", float(speed_mps.max()), limits["rest_mps"], 0.01)
    hover_radps = _hover_radps(flight)
    share = float(flight.rotor_speed_radps[-1].max() / hover_radps)
    yield _at_most("rotors stand still", share, limits["rotor_share"], 0.01)


def _at_touchdown(flight: Recording, row: int) -> Iterator[Finding]:
    limits, time_s, places_m = flight.limits, flight.time_s, flight.position_enu_m
    # 4 ms are a row more, so that the differences cover the whole time.
    before = (time_s >= time_s[row] - _IMPACT_S - 0.004) & (time_s <= time_s[row])
    moves_m = np.linalg.norm(np.diff(places_m[before], axis=0), axis=1)
    speed_mps = float((moves_m / np.diff(time_s[before])).max())
    yield _at_most("touched down softly", speed_mps, limits["touchdown_speed_mps"], 0.05)
    slide_m = float(np.linalg.norm(places_m[row:, :2] - places_m[row, :2], axis=1).max())
    yield _at_most("did not slide", slide_m, limits["slide_m"], 0.02)
    error_m = float(np.linalg.norm(places_m[-1, :2] - _target_m(flight)))
    yield _at_most("near the chosen point", error_m, limits["touchdown_error_m"], 0.005)
    after = flight.rotor_time_s > time_s[row]
    # Thrust follows the square of the speed; in hover it is the weight.
    share = np.mean((flight.rotor_speed_radps[after] / _hover_radps(flight)) ** 2, axis=1)
    # Once the vehicle stands, its rotors slow down; they must not push again afterwards.
    low = np.flatnonzero(share < limits["unloaded_share"])
    again = float(share[low[0] :].max()) if low.size else 0.0
    yield _at_most("rotors did not take the weight again", again, limits["loaded_share"], 0.05)


def _soles_inside(flight: Recording, row: int) -> np.ndarray:
    """For each sole, whether it stands on the area: within the polygon, and near its plane."""
    area, turn = flight.area, flight.attitude[row]
    soles_m = turn.apply(flight.soles_flu_m) + flight.position_enu_m[row]
    corners_m = np.array(area["polygon"])
    middle_m = corners_m.mean(axis=0)
    # Normal of the plane through the polygon's corners.
    normal = np.linalg.svd(corners_m - middle_m)[2][2]
    # Measured vertically, as the limit is.
    height_m = np.abs((soles_m - middle_m) @ normal) / abs(normal[2])
    is_inside = contains_xy(Polygon(corners_m[:, :2]), soles_m[:, 0], soles_m[:, 1])
    return is_inside & (height_m <= flight.limits["surface_tolerance_m"])


def _edge_m(flight: Recording) -> float:
    """Least distance of a sole from the area's edge at the end, m."""
    area = flight.area
    soles_m = flight.attitude[-1].apply(flight.soles_flu_m) + flight.position_enu_m[-1]
    edge = Polygon(np.array(area["polygon"])[:, :2]).exterior
    return float(edge.distance(points(soles_m[:, :2])).min())


def _target_m(flight: Recording) -> np.ndarray:
    """Chosen point if it lies on the area, else the area's centroid; east and north, m."""
    area, chosen_m = flight.area, flight.chosen_enu_m
    footprint = Polygon(np.array(area["polygon"])[:, :2])
    if chosen_m is not None and contains_xy(footprint, *chosen_m[:2]):
        return chosen_m[:2]
    return np.array(area["centroid"][:2])


def _hover_radps(flight: Recording) -> float:
    """Speed of the rotors in hover: the median while they carry the vehicle."""
    mean_radps = flight.rotor_speed_radps.mean(axis=1)
    # A threshold of 0.6 leaves out start, landing and the ground.
    return float(np.median(mean_radps[mean_radps > 0.6 * mean_radps.max()]))


def _no(question: str, holds: bool) -> Finding:
    return Finding(question, None, holds)


def _at_most(question: str, value: float, limit: float, tolerance: float) -> Finding:
    """Finding that a value keeps a limit; within the tolerance it is too close to tell."""
    is_close = abs(value - limit) < tolerance
    return Finding(question, value, None if is_close else bool(value <= limit))
