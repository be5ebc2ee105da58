"""`landing.png`: the pilot's map of the ground that it landed on, layer by layer.

The picture answers why the pilot chose its touchdown point. It shows the true place from above, the
four measured layers with the vehicle's limits, and the judgement that follows from them. The layers
are in the pilot's own frame, so an error of the estimate shows as a shift between them and the
picture.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from autonomy.perception import LandingNeeds
from flightsim.world import build_world
from scenarios.pictures import style
from scenarios.pictures.backdrop import open_stage, opened_above
from scenarios.pictures.story import FlightStory, LandingLayers
from scenarios.pilot.landing_watch import PERCHING_SCATTER_M, SCATTER_M, landing_needs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

_SIZE_IN = (15.0, 9.8)
_PICTURE_PX = 900
_UNSEEN = "#c9ced4"
_JUDGED = ("#d1495b", "#f2b84b", "#3fb56b")
_WORDS = ("unsafe", "safe, but off the area or covered", "safe")
_RELIEF_M = 0.05
"""Least range of heights that the colours span, so that noise on level ground stays pale."""
_MOST_TICKS = 6
_USUAL = 0.9
"""Share of the cells whose heights lie within the range of the colours."""
_ROOM_ABOVE_M = 1.5
"""Height above the touchdown point from which the picture leaves structures out."""


@dataclass(frozen=True, eq=False)
class _Layer:
    """Panel: values by cell, their colours, and the limit that the vehicle sets."""

    title: str
    unit: str
    values: Float[np.ndarray, "n n"]
    top: float
    colours: str = "viridis"
    low: float = 0.0
    limit: float | None = None


def draw_landing(story: FlightStory, paths: Sequence[Path]) -> None:
    """Draw the landing map of a flight into files, each in the format of its name.

    Args:
        story: Flight that looked at an area; `story.landing` is not None.
        paths: Files to write.

    Raises:
        OSError: If one cannot be written.
    """
    assert story.landing is not None
    landing, needs = story.landing, _needs(story)
    figure = style.new_figure(*_SIZE_IN)
    area = "" if story.area is None else f", {story.area.kind} area {story.area.id}"
    style.title(figure, f"{story.title}{area}")
    panels = figure.subplots(2, 3).ravel()
    _draw_picture(panels[0], story, landing)
    for axes, layer in zip(panels[1:5], _layers(landing, needs, _level_m(story)), strict=True):
        _draw_layer(axes, landing, layer)
    _draw_judgement(panels[5], landing)
    _explain(figure, needs)
    for axes in panels:
        _draw_marks(axes, story, needs)
        _frame(axes, landing)
    for path in paths:
        style.save(figure, path)


def _needs(story: FlightStory) -> LandingNeeds:
    """Return the vehicle's needs for a landing site."""
    is_perch = story.area is not None and story.area.kind == "perching"
    return landing_needs(story.airframe, PERCHING_SCATTER_M if is_perch else SCATTER_M)


def _level_m(story: FlightStory) -> float:
    """Return the reference height of the elevation: the touchdown point's or the median."""
    if story.touchdown_enu_m is not None:
        return story.touchdown_enu_m[2]
    assert story.landing is not None
    return float(np.nanmedian(story.landing.height_m))


def _layers(landing: LandingLayers, needs: LandingNeeds, level_m: float) -> list[_Layer]:
    relief_m = landing.height_m - level_m
    # A single pole would otherwise take all the colours for itself.
    reach_m = max(_RELIEF_M, float(np.nanquantile(np.abs(relief_m), _USUAL)))
    slope_deg, steepest_deg = np.degrees(landing.slope_rad), math.degrees(needs.max_slope_rad)
    roughness_cm, roughest_cm = 100 * landing.roughness_m, 100 * needs.max_roughness_m
    clearance_m = landing.clearance_m
    widest_m = max(needs.enough_clearance_m, float(np.nanmax(clearance_m)))
    return [
        _Layer(
            "elevation against the touchdown point", "m", relief_m, reach_m, "RdYlBu_r", -reach_m
        ),
        _Layer("slope under the feet", "degrees", slope_deg, 2 * steepest_deg, limit=steepest_deg),
        _Layer("roughness under the feet", "cm", roughness_cm, 2 * roughest_cm, limit=roughest_cm),
        _Layer("clearance to the nearest unsafe place", "m", clearance_m, widest_m, "cividis"),
    ]


def _draw_layer(axes: Axes, landing: LandingLayers, layer: _Layer) -> None:
    image = _show(axes, landing, layer.values, cmap=layer.colours, vmin=layer.low, vmax=layer.top)
    assert axes.figure is not None
    bar = axes.figure.colorbar(
        image, ax=axes, fraction=0.046, pad=0.02, extend="both" if layer.low < 0 else "max"
    )
    bar.outline.set_visible(False)  # type: ignore[operator]
    bar.ax.tick_params(colors=style.PALE, labelsize=9)
    title = f"{layer.title}, {layer.unit}"
    if layer.limit is not None:
        bar.ax.axhline(layer.limit, color="white", linewidth=2.5)
        title += f" (at most {layer.limit:g})"
        _draw_limit(axes, landing, layer.values, layer.limit)
    style.heading(axes, title)


def _draw_limit(axes: Axes, landing: LandingLayers, values: np.ndarray, limit: float) -> None:
    """Draw the line along which a layer reaches the vehicle's limit."""
    # matplotlib warns about a contour that does not exist.
    known = values[np.isfinite(values)]
    if len(known) and known.min() < limit < known.max():
        axes.contour(
            landing.east_m, landing.north_m, values, [limit], colors="white", linewidths=1.5
        )


def _show(axes: Axes, landing: LandingLayers, values: np.ndarray, **options: object) -> AxesImage:
    axes.set_facecolor(_UNSEEN)
    extent = _extent(landing)
    return axes.imshow(values, origin="lower", extent=extent, **options)  # type: ignore[arg-type]


def _extent(landing: LandingLayers) -> tuple[float, float, float, float]:
    """Return the west, east, south and north edge, half a cell beyond the outer cells' centres."""
    half_m = (landing.east_m[1] - landing.east_m[0]) / 2
    west, east = landing.east_m[[0, -1]] + (-half_m, half_m)
    south, north = landing.north_m[[0, -1]] + (-half_m, half_m)
    return float(west), float(east), float(south), float(north)


def _draw_judgement(axes: Axes, landing: LandingLayers) -> None:
    from matplotlib.colors import ListedColormap

    seen = np.isfinite(landing.height_m)
    # Clearance is zero in cells that are unsafe or not allowed.
    usable = np.nan_to_num(landing.clearance_m) > 0
    kind = np.where(usable, 2.0, np.where(landing.is_safe, 1.0, 0.0))
    colours = ListedColormap(list(_JUDGED))
    _show(axes, landing, np.where(seen, kind, np.nan), cmap=colours, vmin=-0.5, vmax=2.5)
    style.heading(axes, "where the vehicle's centre may come down")


def _explain(figure: Figure, needs: LandingNeeds) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [
        Patch(color=colour, label=words) for colour, words in zip(_JUDGED, _WORDS, strict=True)
    ]
    feet = f"feet and scatter, radius {needs.footprint_radius_m:.2f} m"
    rotors = f"rotors and scatter, radius {needs.body_radius_m:.2f} m"
    handles += [
        Patch(color=_UNSEEN, label="not known"),
        Patch(fill=False, edgecolor=style.INK, label=feet),
        Patch(fill=False, edgecolor=style.INK, linestyle="dashed", label=rotors),
        Line2D([], [], color=style.INK, marker="+", linestyle="none", label="touchdown point"),
        Line2D([], [], color=style.INK, label="border of the area"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=8, fontsize=9, frameon=False)


def _draw_picture(axes: Axes, story: FlightStory, landing: LandingLayers) -> None:
    """Draw the place from above, to the scale of the maps."""
    # The world is the true one, in which the pilot's map lies where the estimate puts it.
    world = build_world(story.scene)
    level_m = _level_m(story)
    west, east, south, north = _extent(landing)
    corners = np.array([(west, south, level_m), (east, north, level_m)])
    # `opened_above` removes what is above the highest point, so this point sets the height.
    lid = np.array([[west, south, level_m + _ROOM_ABOVE_M]])
    with open_stage(opened_above(world, lid), _PICTURE_PX, _PICTURE_PX) as stage:
        picture = stage.from_above(corners, 1.0).rgb
    axes.imshow(picture, extent=(west, east, south, north))
    style.heading(axes, "the place from above")


def _draw_marks(axes: Axes, story: FlightStory, needs: LandingNeeds) -> None:
    """Draw area, touchdown point and the vehicle to scale."""
    from matplotlib.patches import Circle, Polygon

    if story.area is not None:
        corners = np.array([corner[:2] for corner in story.area.polygon])
        # A white line below a dark one is seen on any ground.
        for colour, width in (("white", 3.5), (style.INK, 1.5)):
            axes.add_patch(Polygon(corners, fill=False, edgecolor=colour, linewidth=width))
    if story.touchdown_enu_m is None:
        return
    place = story.touchdown_enu_m[:2]
    for radius_m, pattern in ((needs.footprint_radius_m, "solid"), (needs.body_radius_m, "dashed")):
        for colour, width, line in (("white", 3.0, "solid"), (style.INK, 1.3, pattern)):
            looks = {"edgecolor": colour, "linewidth": width, "linestyle": line}
            axes.add_patch(Circle(place, radius_m, fill=False, **looks))
    axes.plot(*place, "+", color="white", markersize=11, markeredgewidth=3)
    axes.plot(*place, "+", color=style.INK, markersize=10, markeredgewidth=1.3)


def _frame(axes: Axes, landing: LandingLayers) -> None:
    west, east, south, north = _extent(landing)
    axes.set_xlim(west, east)
    axes.set_ylim(south, north)
    axes.set_aspect("equal")
    axes.locator_params(nbins=_MOST_TICKS)
    axes.tick_params(colors=style.PALE, labelsize=9)
    axes.set_xlabel("east, m", color=style.INK, fontsize=9)
    axes.set_ylabel("north, m", color=style.INK, fontsize=9)
    for spine in axes.spines.values():
        spine.set_color(style.RULE)
