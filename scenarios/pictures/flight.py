"""`flight.png`: planned and flown paths, from above and from aside, and over time.

One view cannot show a flight in three dimensions: from above, heights are lost, and from aside,
distances. The picture therefore has both, and two graphs over time below them. docs/recording.md
explains it to readers.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autonomy.types import vector3
from flightsim.world import World, build_world
from scenarios.pictures import style
from scenarios.pictures.backdrop import Backdrop, open_stage, opened_above, surfaces_m
from scenarios.pictures.graphs import draw_errors, draw_profile
from scenarios.pictures.paths import Corner, View
from scenarios.pictures.story import FlightStory, Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

_SIZE_IN = (16.0, 10.4)
_VIEW_PX = (1560, 1400)
_ROOM_M = 3.0
"""Margin shown around the flight."""
_MARGIN = 1.08
_MUCH_HIDDEN = 0.25
"""Share of a path that may be hidden from above before roofs are removed."""
_PLANNED_PT, _FLOWN_PT = 7.5, 2.2
_STRIDE = 5
"""Ticks of 20 ms from one drawn point to the next."""


def draw_flight(story: FlightStory, paths: Sequence[Path]) -> None:
    """Draw the flight into files, each in the format of its name.

    Args:
        story: Flight to draw.
        paths: Files to write; the flight is drawn once for all of them.

    Raises:
        OSError: If one cannot be written.
    """
    world = build_world(story.scene)
    flown = thinned(story.track)
    above, aside, is_opened = _backdrops(story, world, flown)
    figure = style.new_figure(*_SIZE_IN)
    style.title(figure, textwrap.shorten(story.title, 150))
    grid = figure.add_gridspec(2, 2, height_ratios=[2.55, 1.0])
    panels = [figure.add_subplot(grid[place]) for place in ((0, 0), (0, 1))]
    view = View(panels[0], above)
    _draw_view(view, story, flown)
    view.scale(vector3(flown.true_enu_m[0]))
    _explain(panels[0], story, view.emptiest_corner(_framed_paths(story, flown)))
    lines = _draw_view(View(panels[1], aside), story, flown)
    bar = figure.colorbar(lines, ax=panels[1], fraction=0.03, pad=0.01, aspect=50)
    bar.set_label("speed, m/s", color=style.INK)
    bar.outline.set_visible(False)
    style.heading(panels[0], f"from above{', without what is overhead' if is_opened else ''}")
    style.heading(panels[1], "from aside; pale where something is in front")
    draw_profile(figure.add_subplot(grid[1, 0]), story, *surfaces_m(world, flown.true_enu_m), flown)
    draw_errors(figure.add_subplot(grid[1, 1]), story)
    for path in paths:
        style.save(figure, path)


def thinned(track: Track) -> Track:
    """Return every fifth point of a track, and always its last one.

    Args:
        track: Track with a point for each tick of 20 ms.
    """
    keep = np.unique(np.append(np.arange(0, len(track.time_s), _STRIDE), len(track.time_s) - 1))
    return Track(**{row.name: getattr(track, row.name)[keep] for row in fields(Track)})


def _backdrops(story: FlightStory, world: World, flown: Track) -> tuple[Backdrop, Backdrop, bool]:
    """Return views from above and aside, and whether roofs that hid the flight were removed."""
    framed = _framed(story, flown)
    with open_stage(world, *_VIEW_PX) as stage:
        above = stage.from_above(framed, _MARGIN)
        if above.pixels(flown.true_enu_m)[1].mean() < _MUCH_HIDDEN:
            return above, stage.from_aside(framed, _MARGIN), False
    with open_stage(opened_above(world, flown.true_enu_m), *_VIEW_PX) as stage:
        return stage.from_above(framed, _MARGIN), stage.from_aside(framed, _MARGIN), True


def _framed_paths(story: FlightStory, flown: Track) -> np.ndarray:
    """Return the points of the flown path, of the plans and of the area."""
    parts = [flown.true_enu_m, *(leg.points_enu_m for leg in story.plans)]
    if story.area is not None:
        parts.append(np.array(story.area.polygon))
    return np.concatenate(parts)


def _framed(story: FlightStory, flown: Track) -> np.ndarray:
    """Return the points that both views must show: paths, the area and a margin."""
    points = _framed_paths(story, flown)
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array([_ROOM_M, _ROOM_M, 0.0])
    # Four corners of the margin, on the level of the lowest point.
    corners = np.array([(x, y, low[2]) for x in (0, 1) for y in (0, 1)])
    return np.concatenate(
        [points, np.where(corners > 0, 1, 0) * (high - low + 2 * room) + low - room]
    )


def _draw_view(view: View, story: FlightStory, flown: Track) -> LineCollection:
    """Draw everything that both views show, and return the lines that a colour bar explains."""
    if story.area is not None:
        view.area(story.area.polygon, style.AREA)
    for number, mover in enumerate(story.movers):
        colour = style.MOVERS[number % len(style.MOVERS)]
        view.path(mover.points_enu_m, colour, 1.6)
        view.label(mover.points_enu_m[-1], mover.name.replace("_", " "), colour)
    legs = list(zip(story.plans, story.superseded(), strict=True))
    for leg, is_superseded in legs:
        if is_superseded:
            view.path(leg.points_enu_m, style.SUPERSEDED, 1.4)
    # Plans are broad and below, the flown path is narrow and above, so that both can be seen where
    # one follows the other.
    for leg, is_superseded in legs:
        if not is_superseded:
            view.path(leg.points_enu_m, style.PLANNED, _PLANNED_PT)
    lines = view.speed_path(flown.true_enu_m, flown.speed_mps, _top_speed_mps(flown), _FLOWN_PT)
    view.mark(vector3(flown.true_enu_m[0]), "o", "white", 7)
    if story.touchdown_enu_m is not None:
        view.mark(story.touchdown_enu_m, "*", style.TOUCHDOWN, 15)
    return lines


def _top_speed_mps(flown: Track) -> float:
    return max(1.0, float(np.ceil(flown.speed_mps.max())))


def _explain(axes: Axes, story: FlightStory, corner: Corner) -> None:
    from matplotlib.lines import Line2D

    shown = [Line2D([], [], color=style.FLOWN, linewidth=3.0, label="flown, coloured by speed")]
    if story.plans:
        shown.append(Line2D([], [], color=style.PLANNED, linewidth=_PLANNED_PT, label="planned"))
    if any(story.superseded()):
        shown.append(Line2D([], [], color=style.SUPERSEDED, label="planned, then replaced"))
    if story.area is not None:
        shown.append(
            Line2D([], [], color=style.AREA, label=f"{story.area.kind} area {story.area.id}")
        )
    symbols = [("o", "start"), *([("*", "touchdown point")] if story.touchdown_enu_m else [])]
    looks: dict[str, Any] = {
        "color": "white",
        "markeredgecolor": style.INK,
        "linestyle": "none",
        "markersize": 9,
    }
    shown += [Line2D([], [], marker=marker, label=words, **looks) for marker, words in symbols]
    axes.legend(handles=shown, loc=corner, fontsize=9, framealpha=0.85, edgecolor=style.RULE)
