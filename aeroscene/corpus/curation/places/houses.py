"""Detached houses with gardens, drives, garages and terraces; one may be furnished."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import pi

from aeroscene.corpus.curation.builder import Placed
from aeroscene.corpus.curation.frame import INWARD, QUARTER, STREETWARD
from aeroscene.corpus.curation.places.filling import fill_up
from aeroscene.corpus.curation.places.furnished_buildings import furnish, raise_furnished
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.interleaving import interleave
from aeroscene.corpus.curation.places.roadside import park
from aeroscene.corpus.curation.places.rooftops import (
    add_chimney,
    add_flat_roof,
    add_monopitch_roof,
    add_pitched_roof,
)
from aeroscene.corpus.curation.places.seating import dine
from aeroscene.corpus.curation.places.support_surfaces import OpenGround, on_top
from aeroscene.corpus.curation.shells import RoomSpace
from aeroscene.solids.shapes.materials import WALL_COLOURS

_PLOT_M = 12.0
"""Width of street for one house."""
_DRIVE_M = 3.0
_SHELL_PLOT_M = 17.0
"""Width of street for a house that can be entered."""
_LEAST_SHELL_M = (12.2, 15.0)
"""Width beside the drive, and depth, of a plot whose house can be entered."""
_SHELL_DEPTH_M = 8.4
_ROOMS = ("living", "kitchen", "bedroom", "bathroom", "bedroom")


@dataclass(slots=True)
class _Plot:
    """Share of one house in the parcel, as borders of u."""

    low: float
    high: float
    house: Placed | None = None
    roof: Placed | None = None
    drive: Placed | None = None
    garage: Placed | None = None
    terrace: Placed | None = None
    back: float = 0.0
    """End of the house and beginning of the garden, v."""

    @property
    def drive_u(self) -> float:
        """Middle of the drive."""
        # The drive keeps 0.7 m from the neighbour.
        return self.high - 0.7 - _DRIVE_M / 2

    @property
    def house_u(self) -> float:
        """Middle of the plot beside the drive."""
        return (self.low + self.high - 0.7 - _DRIVE_M) / 2

    @property
    def space(self) -> float:
        """Width of the plot beside the drive."""
        return self.high - 0.7 - _DRIVE_M - self.low


@dataclass(slots=True)
class Houses:
    """Plots side by side along the street; the first house may be furnished."""

    ground: Ground
    is_furnished: bool = False
    _plots: list[_Plot] = field(default_factory=list)
    _rooms: list[RoomSpace] = field(default_factory=list)

    def structures(self) -> Iterator[None]:
        """Grow houses first, then drives to garages, terraces, fences and sheds."""
        ground = self.ground
        ground.cover("lawn", {"form": "plain"})
        self._plots = self._part()
        for index, plot in enumerate(self._plots):
            self._raise_house(plot, is_furnished=self.is_furnished and index == 0)
            yield
        for plot in self._plots:
            self._pave_drive(plot)
            self._raise_garage(plot)
            yield
        for plot in self._plots:
            self._lay_terrace(plot)
            yield
        yield from self._fence()
        for plot in self._plots:
            self._raise_shed(plot)
            yield

    def _part(self) -> list[_Plot]:
        """Plots of equal width; the first is wider if its house is to be furnished."""
        width = self.ground.parcel.width
        first = min(width, _SHELL_PLOT_M) if self.is_furnished else 0.0
        count = min(4, int((width - first) / _PLOT_M))
        if count == 0:
            return [_Plot(-width / 2, width / 2)]
        share = (width - first) / count
        borders = [-width / 2 + first + index * share for index in range(count + 1)]
        plots = [_Plot(low, high) for low, high in pairwise(borders)]
        return [_Plot(-width / 2, borders[0]), *plots] if first else plots

    def _raise_house(self, plot: _Plot, *, is_furnished: bool) -> None:
        ground, draw = self.ground, self.ground.draw
        depth = ground.parcel.depth
        # Only a plot that is large enough gets a shell; otherwise the house is a plain mass.
        is_shell = is_furnished and plot.space >= _LEAST_SHELL_M[0] and depth >= _LEAST_SHELL_M[1]
        deep = max(6.2, min(8.6, round(0.38 * depth, 2)))
        deep = _SHELL_DEPTH_M if is_shell else deep
        # Shallow parcels have short front gardens, or hardly any.
        setback = max(0.6, min(draw.between(4.2, 6.0), depth - deep - 0.6))
        plot.back = setback + deep
        if is_shell:
            self._raise_shell(plot, setback)
            return
        length = max(6.0, min(draw.between(8.5, 11.5), plot.space - 1.6))
        storeys = draw.count(1, 2)
        look = {"colour": draw.one_of((*WALL_COLOURS, "brick")), "storeys": storeys}
        size = (deep, round(length, 2), 3.1 if storeys == 1 else 6.0)
        plot.house = ground.erect("house", plot.house_u, setback + deep / 2, size, look=look)
        if plot.house is None:
            return
        if draw.chance(0.3):
            plot.roof = add_monopitch_roof(ground.builder, plot.house)
            return
        plot.roof = add_pitched_roof(ground.builder, draw, plot.house)

    def _raise_shell(self, plot: _Plot, setback: float) -> None:
        ground = self.ground
        deep, length = _SHELL_DEPTH_M, min(10.4, round(plot.space - 1.4, 2))
        shell = raise_furnished(
            ground,
            "house",
            plot.house_u,
            setback + deep / 2,
            deep=deep,
            length=length,
            storeys=1,
            kinds=_ROOMS,
        )
        if shell:
            self._rooms += shell.rooms
            plot.house, plot.back = shell.building, setback + deep
            add_flat_roof(ground.builder, shell.building, parapet=False)

    def _pave_drive(self, plot: _Plot) -> None:
        """Paving from the street to the garage."""
        ground = self.ground
        long = min(round(plot.back - 0.5, 2), round(ground.parcel.depth - 1.0, 2), 9.0)
        size = (long, _DRIVE_M, 0.05)
        plot.drive = ground.stand("sidewalk", plot.drive_u, long / 2, size, turn=INWARD, margin=0.0)

    def _raise_garage(self, plot: _Plot) -> None:
        """A garage at the drive's end, its door to the street."""
        ground = self.ground
        start = plot.drive.size[0] if plot.drive else 6.0
        # A garage is 5.8 m deep and keeps a margin on both sides.
        if ground.parcel.depth - start < 6.5:
            return
        look = {"form": "garage"}
        plot.garage = ground.erect("garage", plot.drive_u, start + 3.35, (5.8, 3.1, 2.7), look=look)

    def _lay_terrace(self, plot: _Plot) -> None:
        """A deck on the garden side of the house."""
        ground = self.ground
        if plot.house is None or ground.parcel.depth - plot.back < 4.2:
            return
        length = min(5.5, round(plot.house.size[1] - 0.5, 2))
        size = (3.2, length, 0.15)
        plot.terrace = ground.stand(
            "deck", plot.house_u, plot.back + 1.7, size, turn=INWARD, margin=0.02
        )

    def _fence(self) -> Iterator[None]:
        """Boards or hedges between neighbours, and along the back."""
        ground, draw = self.ground, self.ground.draw
        half, depth = ground.parcel.width / 2, ground.parcel.depth
        back = depth - 0.3
        form = draw.one_of(("hedge", "boards", "boards"))
        ground.fence_line((-half + 0.4, back), (half - 0.4, back), form, draw.between(1.2, 1.7))
        yield
        for plot in self._plots[:-1]:
            form = draw.one_of(("hedge", "boards"))
            height = draw.between(1.0, 1.5)
            ground.fence_line((plot.high, 1.0), (plot.high, back - 0.4), form, height)
            yield
        plot = self._plots[0]
        end = plot.drive_u - _DRIVE_M / 2 - 0.5
        middle = plot.house_u
        # The hedge leaves 2 m for the door in the middle of the house.
        ground.fence_line((plot.low + 0.4, 0.4), (middle - 1.0, 0.4), "hedge", 0.9)
        ground.fence_line((middle + 1.0, 0.4), (end, 0.4), "hedge", 0.9)
        yield

    def _raise_shed(self, plot: _Plot) -> None:
        """A garden shed in the corner at the back."""
        ground, draw = self.ground, self.ground.draw
        if ground.parcel.depth - plot.back < 6.5:
            return
        look = {"form": "shed"}
        u = plot.low + 2.4 if draw.chance(0.5) else plot.high - 2.4
        at = (u, ground.parcel.depth - 2.4)
        ground.erect("garage", *at, (2.4, 3.0, 2.4), look=look)

    def details(self) -> Iterator[None]:
        """Grow furniture, then cars on the drives, and the life of the gardens."""
        yield from interleave(
            furnish(self.ground, self._rooms),
            self._front(),
            *(self._garden(plot) for plot in self._plots),
        )

    def _front(self) -> Iterator[None]:
        """A car on each drive, a chimney on each roof, bins and a bicycle by the door."""
        ground, draw = self.ground, self.ground.draw
        for plot in self._plots:
            turn = pi if draw.chance(0.6) else 0.0
            if plot.drive:
                lane = on_top(ground, plot.drive)
                at = draw.between(-0.1, 0.1) * plot.drive.size[0]
                park(lane, "car", plot.drive.frame, at, 0.0, turn)
            else:
                park(OpenGround(ground), "car", ground.parcel.frame, plot.drive_u, 3.0, INWARD)
            yield
        for plot in self._plots:
            # Low roofs are monopitch roofs, which have no chimney.
            if plot.roof and plot.roof.size[2] > 1.6:
                add_chimney(ground.builder, draw, plot.roof)
            bins = plot.drive_u - _DRIVE_M / 2 - 0.6
            for index in range(draw.count(1, 2)):
                ground.stand("bin", bins, 1.2 + 0.8 * index, (0.7, 0.6, 1.1), turn=STREETWARD)
            yield
        for plot in self._plots:
            near = (plot.low, plot.drive_u - _DRIVE_M / 2, 0.6, 4.2)
            ground.scatter("bush", 2, near=near)
            yield
            ground.plant_trees(1, near)
            ground.scatter("planter", 1, near=near, turn=0.0)
            yield
            if plot.house:
                step = plot.house.size[0] / 2 + 0.6
                size = (1.75, 0.55, 1.05)
                spot = plot.house.frame.moved(step, 1.6, QUARTER)
                OpenGround(ground).stand("bicycle", spot, size)
            ground.scatter("bush", 1, near=near)
            yield

    def _garden(self, plot: _Plot) -> Iterator[None]:
        """The terrace with its table, trees, a bench, beds of vegetables."""
        ground, depth = self.ground, self.ground.parcel.depth
        if depth - plot.back < 3:
            return
        if plot.terrace:
            terrace = plot.terrace
            yield from dine(on_top(ground, terrace), terrace.frame, [(0.1, 0.6)], QUARTER)
            for sign in (-1, 1):
                edge = sign * (terrace.size[1] / 2 - 0.35)
                spot = terrace.frame.moved(-1.0, edge)
                on_top(ground, terrace).stand("planter", spot, (1.0, 0.5, 0.9))
            yield
        garden = (plot.low + 0.4, plot.high - 0.4, plot.back + 3.4, depth - 0.6)
        ground.plant_trees(2, garden)
        yield
        self._beds(plot)
        yield
        middle = (plot.low + plot.high) / 2
        ground.stand("bench", middle, depth - 1.2, (0.6, 1.8, 0.85), turn=STREETWARD)
        ground.scatter("bush", 2, near=garden)
        yield
        names = ("bush", "tree", "planter", "bush", "chair", "bin", "bicycle", "tree")
        yield from fill_up(ground, names, garden, 10)

    def _beds(self, plot: _Plot) -> None:
        """Raised beds in a row."""
        ground, draw = self.ground, self.ground.draw
        v = ground.parcel.depth - 2.2
        u = plot.high - 1.6 if draw.chance(0.5) else plot.low + 1.6
        for index in range(3):
            size = (1.2, 2.4, 0.7)
            ground.stand("planter", u, v - 1.9 * index, size, turn=QUARTER, margin=0.2)
