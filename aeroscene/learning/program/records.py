"""Records of partitions as nested tokens with channels, and back from any channels.

    record             channels
    part of a parent   0: log of the share, about the mean of those beside it
    `width`            1: log m
    `site`             1 to 7: x, y, cos, sin beyond quarter turns, log length, log width, base
    `storey`           1 to 10: middle, cos, sin, length and width in the host's, level, walls,
                       outer, drop
    `leaf`, `lane`     1 on: log height, of each piece
    `pinwheel`         1 to 4: log of the sides' shares over the middle's
    `item`             1 to 6: middle in shares, cos, sin, log length, log width
    `bend`             1 on: start, cos, sin, log lengths, turns
    `bank`             1 to 3: low end, log length in shares, log depth
    `segment`          1, 2: sill, head

Lengths are logarithms and headings unit vectors, so that any number that a network gives is a valid
record. Shares are logarithms about their mean for the same reason: `shares_of` normalises them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from aeroscene.learning.program.program import N_CHANNELS
from aeroscene.partition import Record

PARTS = {
    "slice": lambda r: ((0, r.arity),),
    "cross": lambda r: ((0, r.arity), (r.arity, r.arity + r.rows)),
    "grid": lambda r: ((0, r.arity), (r.arity, r.arity + r.rows)),
    "border": lambda r: ((0, r.arity),),
}
"""Slices of a record's children that divide one side, by node."""
# Bounds that keep logarithms and exponentials finite.
_LEAST = 1e-6
_MOST_LOG = 7.0


def n_children(record: Record) -> int:
    """Return the number of records right below a record; a storey's borders do not count."""
    match record.node:
        case "slice" | "border":
            return record.arity
        case "cross" | "grid":
            # Columns, rows and cells.
            return record.arity + record.rows + record.arity * record.rows
        case "pinwheel":
            return 5
        case "overlay":
            return 1 + record.arity
        case "bend":
            # Lanes, and two banks for each piece.
            return record.rows + 2 * record.arity
        case "bank":
            return int(record.is_placed)
        case "site" | "storey" | "item":
            return 1
        case _:
            return 0


def channels_of(record: Record) -> Float[np.ndarray, " 19"]:
    """Return the numbers of a record, without its share."""
    channels = np.full(N_CHANNELS, np.nan)
    values = _to_channels(record, record.values)
    channels[1 : 1 + len(values)] = values
    return channels


def _to_channels(record: Record, values: Sequence[float]) -> list[float]:
    match record.node:
        case "width":
            return [_log(values[0])]
        case "leaf" | "lane":
            # A height of 0 means that there is none.
            return [_log(value) if value > 0 else math.nan for value in values]
        case "site":
            x, y, yaw, length, width, base = values
            return [x, y, math.cos(yaw), math.sin(yaw), _log(length), _log(width), base]
        case "pinwheel":
            west, east, south, north = values
            x, y = _log(east - west), _log(north - south)
            return [_log(west) - x, _log(1 - east) - x, _log(south) - y, _log(1 - north) - y]
        case "item" if record.is_placed:
            x, y, yaw, length, width = values
            return [x, y, math.cos(yaw), math.sin(yaw), _log(length), _log(width)]
        case "bend":
            n = record.arity
            u, v, heading, *rest = values
            logs = [_log(length) for length in rest[:n]]
            return [u, v, math.cos(heading), math.sin(heading), *logs, *rest[n:]]
        case "bank" if record.is_placed:
            low, high, depth = values
            return [low, _log(high - low), _log(depth)]
        case _:
            return list(values)


def values_of(record: Record, channels: Float[np.ndarray, " 19"]) -> tuple[float, ...]:
    """Return the numbers of a record from its channels, within the range that it may have.

    Args:
        record: The record, of which node, arity and kind are read.
        channels: Any numbers; NaN counts as 0, or as "absent" for heights.
    """
    c = np.nan_to_num(channels[1:]).tolist()
    found: tuple[float, ...] = ()
    match record.node:
        case "width":
            found = (_metres(c[0]),)
        case "leaf":
            found = (0.0 if math.isnan(channels[1]) else _metres(c[0]),)
        case "lane":
            found = tuple(_metres(each) for each in channels[1:].tolist() if not math.isnan(each))
        case "site":
            found = (c[0], c[1], math.atan2(c[3], c[2]), _exp(c[4]), _exp(c[5]), c[6])
        case "pinwheel":
            found = (*_middle(c[0], c[1]), *_middle(c[2], c[3]))
        case "item" if record.is_placed:
            found = (*_shares(c[:2]), math.atan2(c[3], c[2]), _exp(c[4]), _exp(c[5]))
        case "bend":
            n = record.arity
            # A bend turns by one radian at most between two pieces.
            turns = [min(1.0, max(-1.0, turn)) for turn in c[4 + n : 3 + 2 * n]]
            lengths = [_exp(value) for value in c[4 : 4 + n]]
            found = (c[0], c[1], math.atan2(c[3], c[2]), *lengths, *turns)
        case "bank" if record.is_placed:
            found = (c[0], c[0] + _exp(c[1]), _exp(c[2]))
        case "segment" if record.kind in {"door", "window"}:
            sill = max(0.0, c[0])
            # An opening is at least 0.3 m high.
            found = sill, max(sill + 0.3, c[1])
        case "segment":
            found = 0.0, 0.0
        case _:
            pass
    return found


def share_logits(shares: Sequence[float]) -> list[float]:
    """Return shares as numbers about zero.

    Args:
        shares: Shares of the parts of a side; 0 for strips, which have none.

    Returns:
        Logarithms less their mean; NaN for strips.
    """
    logs = [_log(share) if share > 0 else math.nan for share in shares]
    known = [value for value in logs if not math.isnan(value)]
    middle = sum(known) / len(known) if known else 0.0
    return [value - middle for value in logs]


def shares_of(logits: Sequence[float]) -> list[float]:
    """Return shares that sum to one from any numbers; 0 for those that are NaN."""
    known = [value for value in logits if not math.isnan(value)]
    top = max(known, default=0.0)
    # No part vanishes: each has at least a thousandth of the largest.
    weights = [0.0 if math.isnan(v) else max(math.exp(v - top), 1e-3) for v in logits]
    total = sum(weights) or 1.0
    return [weight / total for weight in weights]


def _middle(low: float, high: float) -> tuple[float, float]:
    """Return the sides of a middle from logs of the shares before and behind it over its own."""
    before, behind = _exp(min(low, 3.0)), _exp(min(high, 3.0))
    total = before + 1.0 + behind
    return before / total, (before + 1.0) / total


def _shares(values: Sequence[float]) -> list[float]:
    return [min(1.0, max(0.0, value)) for value in values]


def _log(value: float) -> float:
    return math.log(max(value, _LEAST))


def _metres(log: float) -> float:
    """Return a length to a tenth of a millimetre, as single precision knows no more."""
    return round(_exp(log), 4)


def _exp(value: float) -> float:
    return math.exp(min(max(value, -_MOST_LOG), _MOST_LOG))
