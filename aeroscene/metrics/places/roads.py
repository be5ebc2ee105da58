"""Roads and water: direction of traffic, lights beside roads, boats on water, bridges over them."""

from __future__ import annotations

import math

import numpy as np
import shapely
from jaxtyping import Bool

from aeroscene.feasibility.strays import LEAST_ON_WATER, TO_ROAD_M
from aeroscene.metrics.places.top_view import TopView, near_pairs, union
from aeroscene.scene.catalogue import AFLOAT, BRIDGES, ROADS, SIGNALS, VEHICLES, WATER

ALONG_RAD = math.radians(45.0)
"""Greatest angle between a road and a vehicle that drives along it."""
LEAST_OVER = 0.1
"""Least share of a bridge's outline over the water or road that it crosses."""


def wrong_way_vehicles(view: TopView) -> Bool[np.ndarray, " vehicles"]:
    """True for each vehicle on a road that drives on the left or stands across it.

    A vehicle is on a road if its centre lies within the road's outline. Of several roads the one
    counts whose direction is nearest to its own. It is on the left if the middle of the road is to
    its right. It stands across the road if the angle is over `ALONG_RAD`. Vehicles off the roads
    are not judged.
    """
    vehicles, roads = view.rows(VEHICLES), view.rows(ROADS)
    centres = shapely.points(view.centre_m[vehicles])
    vehicle, road = near_pairs(centres, view.outline[roads], 0.0)
    heading, across = view.forward[vehicles[vehicle]], view.leftward[vehicles[vehicle]]
    cosine = np.abs((heading * view.forward[roads[road]]).sum(axis=1))
    to_middle_m = view.centre_m[roads[road]] - view.centre_m[vehicles[vehicle]]
    # The road's own axis across it, in the sign in which it points to the vehicle's left.
    leftward = view.leftward[roads[road]]
    leftward = leftward * np.sign((leftward * across).sum(axis=1, keepdims=True))
    is_wrong = ((to_middle_m * leftward).sum(axis=1) < 0) | (cosine < math.cos(ALONG_RAD))
    best = np.lexsort((-cosine, vehicle))
    # The first row of each vehicle is the road that fits its heading best.
    first = np.unique(vehicle[best], return_index=True)[1]
    return is_wrong[best[first]]


def lights_off_roads(view: TopView) -> Bool[np.ndarray, " lights"]:
    """True for each traffic light over `TO_ROAD_M` from the outline of every road."""
    lights, roads = view.rows(SIGNALS), view.rows(ROADS)
    is_off = np.ones(len(lights), dtype=bool)
    is_off[near_pairs(view.outline[lights], view.outline[roads], TO_ROAD_M)[0]] = False
    return is_off


def stranded_boats(view: TopView) -> Bool[np.ndarray, " boats"]:
    """True for each boat with less than `LEAST_ON_WATER` of its outline on water."""
    boats, water = view.outline[view.rows(AFLOAT)], union(view.outline[view.rows(WATER)])
    afloat = shapely.area(shapely.intersection(boats, water)) / shapely.area(boats)
    return afloat < LEAST_ON_WATER


def idle_bridges(view: TopView) -> Bool[np.ndarray, " bridges"]:
    """True for each bridge with less than `LEAST_OVER` of its outline over water or road."""
    bridges = view.outline[view.rows(BRIDGES)]
    crossed = union(view.outline[view.rows(WATER | ROADS)])
    over = shapely.area(shapely.intersection(bridges, crossed)) / shapely.area(bridges)
    return over < LEAST_OVER
