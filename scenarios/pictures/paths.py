"""Paths, areas, labels and a scale, drawn into a rendered view."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Bool, Float

from autonomy.types import Vector3
from scenarios.pictures import style
from scenarios.pictures.backdrop import Backdrop

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

Corner = Literal["upper left", "upper right", "lower right"]

_HIDDEN_ALPHA = 0.3
_LEGEND_SHARE = 0.34
"""Share of a view's width and height that a legend in its corner covers."""


class View:
    """Panel that shows a backdrop, and draws into it; hidden parts of paths are pale."""

    def __init__(self, axes: Axes, backdrop: Backdrop) -> None:
        self.axes = axes
        self._backdrop = backdrop
        height, width, _ = backdrop.rgb.shape
        axes.imshow(backdrop.rgb, interpolation="antialiased", aspect="equal")
        axes.set_xlim(-0.5, width - 0.5)
        # Rows count downwards, and pixel centres have whole numbers.
        axes.set_ylim(height - 0.5, -0.5)
        axes.set_xticks([])
        axes.set_yticks([])
        for spine in axes.spines.values():
            spine.set_visible(False)

    def path(self, points_enu_m: Float[np.ndarray, "n 3"], colour: str, width: float) -> None:
        """Draw a line of one colour.

        Args:
            points_enu_m: Points of the line, in the world.
            colour: Colour of matplotlib's.
            width: Width in points.
        """
        segments, is_hidden = self._segments(points_enu_m)
        for part, alpha in ((~is_hidden, 1.0), (is_hidden, _HIDDEN_ALPHA)):
            self._add(segments[part], width, colors=colour, alpha=alpha, capstyle="round")

    def speed_path(
        self,
        points_enu_m: Float[np.ndarray, "n 3"],
        speed_mps: Float[np.ndarray, " n"],
        top_mps: float,
        width: float,
    ) -> LineCollection:
        """Draw a line coloured by speed, with a dark rim.

        Args:
            points_enu_m: Points of the line, in the world.
            speed_mps: Speed at each point.
            top_mps: Speed of the last colour.
            width: Width in points.

        Returns:
            The visible line, which a colour bar needs.
        """
        from matplotlib.colors import Normalize

        segments, is_hidden = self._segments(points_enu_m)
        shown = segments[~is_hidden]
        self._add(shown, width + 1.4, colors=style.INK, capstyle="round")
        scale = Normalize(0.0, top_mps)
        options = {"cmap": style.SPEED_MAP, "norm": scale, "capstyle": "round"}
        pale = {"alpha": _HIDDEN_ALPHA, **options}
        self._add(segments[is_hidden], width, array=speed_mps[1:][is_hidden], **pale)
        return self._add(shown, width, array=speed_mps[1:][~is_hidden], **options)

    def _segments(
        self, points_enu_m: Float[np.ndarray, "n 3"]
    ) -> tuple[Float[np.ndarray, "m 2 2"], Bool[np.ndarray, " m"]]:
        pixels, is_hidden = self._backdrop.pixels(points_enu_m)
        # Segments of two points each, because a line has one colour and one opacity.
        segments = np.stack([pixels[:-1], pixels[1:]], axis=1)
        # A segment counts as hidden only if both of its ends are.
        return segments, is_hidden[:-1] & is_hidden[1:]

    def _add(self, segments: np.ndarray, width: float, **options: object) -> LineCollection:
        from matplotlib.collections import LineCollection

        lines = LineCollection(list(segments), linewidths=width, **options)  # type: ignore[arg-type]
        self.axes.add_collection(lines, autolim=False)
        return lines

    def area(self, polygon_enu_m: Sequence[Vector3], colour: str) -> None:
        """Draw a polygon with its outline and a transparent fill.

        Args:
            polygon_enu_m: Corners in order; a polygon that is partly behind the eye is left out.
            colour: Colour of matplotlib's.
        """
        from matplotlib.patches import Polygon

        pixels, _ = self._backdrop.pixels(np.array(polygon_enu_m))
        if np.isfinite(pixels).all():
            self.axes.add_patch(Polygon(pixels, facecolor=colour, alpha=0.3))
            self.axes.add_patch(Polygon(pixels, fill=False, edgecolor=colour, linewidth=1.8))

    def mark(self, point_enu_m: Vector3, marker: str, colour: str, size: float) -> None:
        """Draw a symbol at a point.

        Args:
            point_enu_m: Point in the world; it is drawn even if something hides it.
            marker: Symbol of matplotlib's, such as "o" or "*".
            colour: Colour of matplotlib's.
            size: Size in points.
        """
        pixels, _ = self._backdrop.pixels(np.array([point_enu_m]))
        self.axes.plot(
            *pixels[0], marker, color=colour, markersize=size, markeredgecolor=style.INK, zorder=5
        )

    def label(self, point_enu_m: Float[np.ndarray, " 3"], text: str, colour: str) -> None:
        """Draw a small label beside a point, if it is in the picture."""
        (column, row), _ = (values[0] for values in self._backdrop.pixels(point_enu_m[None]))
        height, width, _ = self._backdrop.rgb.shape
        # Room for the text at the right and above, so that it stays within the picture.
        if 0 <= column < 0.93 * width and 0.03 * height <= row < height:
            place = self.axes.annotate(
                text, (column, row), (5, 5), textcoords="offset points", fontsize=8, color="white"
            )
            place.set_bbox({"facecolor": colour, "alpha": 0.85, "pad": 1.5, "edgecolor": "none"})

    def emptiest_corner(self, points_enu_m: Float[np.ndarray, "n 3"]) -> Corner:
        """Return the corner where a legend hides the fewest points.

        The lower left is not among them, because the scale is there.

        Args:
            points_enu_m: Points that should stay visible.
        """
        pixels, _ = self._backdrop.pixels(points_enu_m)
        height, width, _ = self._backdrop.rgb.shape
        column, row = pixels[:, 0] / width, pixels[:, 1] / height
        corners: dict[Corner, np.ndarray] = {
            "upper left": (column < _LEGEND_SHARE) & (row < _LEGEND_SHARE),
            "upper right": (column > 1 - _LEGEND_SHARE) & (row < _LEGEND_SHARE),
            "lower right": (column > 1 - _LEGEND_SHARE) & (row > 1 - _LEGEND_SHARE),
        }
        return min(corners, key=lambda corner: int(np.count_nonzero(corners[corner])))

    def scale(self, at_enu_m: Vector3) -> None:
        """Draw a bar of a round length at the lower left.

        Args:
            at_enu_m: Point at whose distance from the eye the length is true.
        """
        height, width, _ = self._backdrop.rgb.shape
        per_m = self._backdrop.pixels_per_m(at_enu_m)
        length_m = style.round_length_m(width / per_m)
        left, base = 0.03 * width, 0.96 * height
        # A light bar on a dark one is seen on any ground.
        for colour, thickness in ((style.INK, 6.0), ("white", 3.0)):
            self.axes.plot(
                [left, left + length_m * per_m],
                [base, base],
                color=colour,
                linewidth=thickness,
                solid_capstyle="butt",
            )
        self._caption(left, base - 0.015 * height, f"{length_m:g} m, north is up")

    def _caption(self, column: float, row: float, text: str) -> None:
        place = self.axes.text(column, row, text, fontsize=9, color="white", va="bottom")
        place.set_bbox({"facecolor": style.INK, "alpha": 0.6, "pad": 2.0, "edgecolor": "none"})
