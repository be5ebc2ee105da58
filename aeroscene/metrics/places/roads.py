"""Roads and water: who drives where, what stands beside, what crosses them."""

from __future__ import annotations

import math

import numpy as np
import shapely
from jaxtyping import Bool

from aeroscene.feasibility.strays import LEAST_ON_WATER, TO_ROAD_M
from aeroscene.metrics.places.top_view import TopView, near_pairs, union
from aeroscene.scene.catalogue import AFLOAT, BRIDGES, ROADS, SIGNALS, VEHICLES, WATER

ALONG_RAD = math.radians(45.0)
"""Largest angle between a road and what drives along it."""
LEAST_OVER = 0.1
"""Least share of a bridge's outline over what it crosses."""


def wrong_way_vehicles(view: TopView) -> Bool[np.ndarray, " vehicles"]:
    """Whether each vehicle on a road has the middle of the road to its right, or stands across it.

    A vehicle is on a road where its centre lies within the road's outline; of several roads that
    which it heads along most nearly. It stands across it at over `ALONG_RAD` to its x axis.
    Vehicles off the roads are not judged.
    """
    vehicles, roads = view.rows(VEHICLES), view.rows(ROADS)
    centres = shapely.points(view.centre_m[vehicles])
    vehicle, road = near_pairs(centres, view.outline[roads], 0.0)
    heading, across = view.forward[vehicles[vehicle]], view.leftward[vehicles[vehicle]]
    cosine = np.abs((heading * view.forward[roads[road]]).sum(axis=1))
    to_middle_m = view.centre_m[roads[road]] - view.centre_m[vehicles[vehicle]]
    # The road's own line through its middle, where the vehicle's left hand meets it.
    leftward = view.leftward[roads[road]]
    leftward = leftward * np.sign((leftward * across).sum(axis=1, keepdims=True))
    is_wrong = ((to_middle_m * leftward).sum(axis=1) < 0) | (cosine < math.cos(ALONG_RAD))
    best = np.lexsort((-cosine, vehicle))
    first = np.unique(vehicle[best], return_index=True)[1]
    return is_wrong[best[first]]


def lights_off_roads(view: TopView) -> Bool[np.ndarray, " lights"]:
    """Whether each traffic light stands over `TO_ROAD_M` from the outline of every road."""
    lights, roads = view.rows(SIGNALS), view.rows(ROADS)
    is_off = np.ones(len(lights), dtype=bool)
    is_off[near_pairs(view.outline[lights], view.outline[roads], TO_ROAD_M)[0]] = False
    return is_off


def stranded_boats(view: TopView) -> Bool[np.ndarray, " boats"]:
    """Whether less than `LEAST_ON_WATER` of the outline of each boat lies on water."""
    boats, water = view.outline[view.rows(AFLOAT)], union(view.outline[view.rows(WATER)])
    afloat = shapely.area(shapely.intersection(boats, water)) / shapely.area(boats)
    return afloat < LEAST_ON_WATER


def idle_bridges(view: TopView) -> Bool[np.ndarray, " bridges"]:
    """Whether less than `LEAST_OVER` of the outline of each bridge lies over water or road."""
    bridges = view.outline[view.rows(BRIDGES)]
    crossed = union(view.outline[view.rows(WATER | ROADS)])
    over = shapely.area(shapely.intersection(bridges, crossed)) / shapely.area(bridges)
    return over < LEAST_OVER
