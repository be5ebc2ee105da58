"""Themes of sites: the plan that their streets follow, and the places on their parcels.

A theme keeps streets and places together, so that a farm does not stand in a town. Each theme has
places that are certain and places that chance adds. Site plans are tried on paper first, because
not every plan has parcels that are large enough for the certain ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from aeroscene.corpus.curation.builder import Builder
from aeroscene.corpus.curation.composition import Composition, Place
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.parcels import Parcel
from aeroscene.corpus.curation.places.allotments import Allotments
from aeroscene.corpus.curation.places.clinic import Clinic
from aeroscene.corpus.curation.places.closed_block import ClosedBlock
from aeroscene.corpus.curation.places.construction import Construction
from aeroscene.corpus.curation.places.depot import Depot
from aeroscene.corpus.curation.places.farm import Farm
from aeroscene.corpus.curation.places.filling_station import FillingStation
from aeroscene.corpus.curation.places.flats import Flats
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.houses import Houses
from aeroscene.corpus.curation.places.market import Market
from aeroscene.corpus.curation.places.offices import Offices
from aeroscene.corpus.curation.places.park import Park
from aeroscene.corpus.curation.places.parking import Parking
from aeroscene.corpus.curation.places.retail import Retail
from aeroscene.corpus.curation.places.row_houses import RowHouses
from aeroscene.corpus.curation.places.school import School
from aeroscene.corpus.curation.places.shops import Shops
from aeroscene.corpus.curation.places.site_borders import Bordered, outer_sides
from aeroscene.corpus.curation.places.sports_ground import SportsGround
from aeroscene.corpus.curation.places.square import Square
from aeroscene.corpus.curation.places.station import Station
from aeroscene.corpus.curation.places.terraces import Terraces
from aeroscene.corpus.curation.places.waterfront import Waterfront
from aeroscene.corpus.curation.places.yard import Yard
from aeroscene.corpus.curation.site import Site
from aeroscene.corpus.curation.sites import Scale, lay_out_site
from aeroscene.corpus.curation.start import place_start
from aeroscene.corpus.curation.streets import Streets
from aeroscene.corpus.curation.terrain import Slope, raise_terrace
from aeroscene.corpus.curation.water import Basin

# At least so high is the flight volume; tall objects raise it.
_CEILING_M = 22.0
_TRIES = 200
"""Sites tried on paper at most. One in 2,000 scenes has no ground in the first 20."""


class NoGroundError(RuntimeError):
    """Raised if no site of a theme has parcels for the places that it cannot do without."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of place and the least ground that it needs, m."""

    make: Callable[[Ground], Place]
    width: float
    depth: float
    is_lifted: bool = True
    """True if it may stand on a terrace above the street; false if vehicles drive in."""
    border: tuple[str, float] | None = None
    """Form and height (m) of its fences where the site ends."""

    def fits(self, parcel: Parcel) -> bool:
        """Return true if a parcel is large enough, in width and in depth."""
        return parcel.width >= self.width and parcel.depth >= self.depth


# Least width and depth of the ground of each, m.
KINDS: Mapping[str, Kind] = {
    "offices": Kind(Offices, 17, 18, border=("hedge", 1.2)),
    "houses": Kind(Houses, 16, 15, border=("boards", 1.5)),
    "furnished_house": Kind(partial(Houses, is_furnished=True), 18, 15, border=("boards", 1.5)),
    "flats": Kind(Flats, 14, 14, border=("hedge", 1.2)),
    "closed_block": Kind(ClosedBlock, 11, 8, is_lifted=False),
    "row_houses": Kind(RowHouses, 14, 13, border=("boards", 1.5)),
    "shops": Kind(Shops, 14, 12, is_lifted=False),
    "square": Kind(Square, 16, 18, is_lifted=False),
    "clinic": Kind(Clinic, 22, 18, is_lifted=False),
    "retail": Kind(Retail, 18, 22, is_lifted=False, border=("hedge", 1.1)),
    "filling_station": Kind(FillingStation, 18, 18, is_lifted=False, border=("hedge", 1.1)),
    "sports_ground": Kind(SportsGround, 20, 17, border=("mesh", 2.0)),
    "allotments": Kind(Allotments, 14, 13, border=("hedge", 1.2)),
    "farm": Kind(Farm, 24, 22, border=("rails", 1.2)),
    "marina": Kind(partial(Waterfront, is_marina=True), 18, 20, is_lifted=False),
    "park": Kind(Park, 12, 12, border=("hedge", 1.3)),
    "market": Kind(Market, 12, 12, border=("rails", 1.1)),
    "school": Kind(School, 20, 20, border=("rails", 1.4)),
    "terraces": Kind(Terraces, 13, 20, border=("hedge", 1.1)),
    "waterfront": Kind(Waterfront, 18, 20, is_lifted=False),
    "station": Kind(Station, 20, 15, is_lifted=False, border=("rails", 1.1)),
    "parking": Kind(Parking, 12, 17, is_lifted=False, border=("hedge", 1.1)),
    "construction": Kind(Construction, 17, 17, is_lifted=False, border=("boards", 1.9)),
    "yard": Kind(Yard, 18, 18, is_lifted=False, border=("mesh", 2.0)),
    "depot": Kind(Depot, 20, 20, is_lifted=False, border=("mesh", 2.0)),
    "warehouse": Kind(
        partial(Depot, is_furnished=True), 20, 20, is_lifted=False, border=("mesh", 2.0)
    ),
}
"""Kinds of places under the names that themes use."""

_ANYWHERE = "park"
"""Use of a parcel that is too small for everything else."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """A character that streets and places of a scene share."""

    weight: float
    """Relative frequency of the theme."""
    plans: Mapping[str, float]
    """Ground plans and their weights."""
    always: Sequence[Sequence[str]] = ()
    """Rows of kinds. One kind of each row is drawn, and it gets a parcel before `others` do.

    A site is taken only if each row has a parcel that is free and large enough for every kind of
    the row, so that any of them can be drawn. One large kind thus makes a row hard to fit. Parcels
    are filled from the largest to the smallest, and each gets the first row that still waits and
    whose kind fits. If two rows need the same parcel, the later row may go without.
    """
    others: Mapping[str, float]
    """Kinds of the other parcels and their weights."""
    fulness: float = 1.0
    """Number of fine objects, relative to the average scene."""
    terrace_chance: float = 0.1
    """Probability that a parcel is lifted above the street."""
    scale: Scale = field(default_factory=Scale)
    """Size of its sites and width of its streets."""


def compose_theme(
    builder: Builder, rng: np.random.Generator, themes: Mapping[str, Theme]
) -> Composition:
    """Draw a theme, lay its streets and give every parcel a place.

    Args:
        builder: Empty builder of the scene.
        rng: Randomness of the layout.
        themes: Themes by name.

    Raises:
        NoGroundError: If no site of the theme has the parcels that it needs.
    """
    name = draw_one(rng, {name: theme.weight for name, theme in themes.items()})
    theme = themes[name]
    plan, choice, start, streets = rng.spawn(4)
    site = _lay_fitting_site(builder, plan, theme)
    east, north = site.half_extent
    return Composition(
        theme=name,
        places=[
            *choose_places(builder, site, theme, choice),
            *grow_nature(builder, site, choice),
            Streets(builder, Draw(streets), site),
        ],
        extent_min_enu_m=(-east, -north, 0.0),
        extent_max_enu_m=(east, north, _CEILING_M),
        fulness=theme.fulness,
        place_start=partial(place_start, builder, Draw(start), (east, north)),
    )


def _lay_fitting_site(builder: Builder, rng: np.random.Generator, theme: Theme) -> Site:
    """Return the first of some sites that has ground for all the certain places of a theme.

    Raises:
        NoGroundError: If none has it.
    """
    for _ in range(_TRIES):
        plan, seed = draw_one(rng, theme.plans), int(rng.integers(1 << 62))
        # The draft goes to a builder of its own; the same seed then lays the same site for good.
        draft = lay_out_site(Builder("draft"), np.random.default_rng(seed), plan, theme.scale)
        if all(any(_suits(row, parcel) for parcel in draft.parcels) for row in theme.always):
            return lay_out_site(builder, np.random.default_rng(seed), plan, theme.scale)
    raise NoGroundError(
        f"{builder.scene_id}: no site in {_TRIES} has ground for {list(theme.always)}; "
        f"valid: a theme whose plans {list(theme.plans)} leave parcels large enough"
    )


def _suits(kinds: Sequence[str], parcel: Parcel) -> bool:
    """Return true if a parcel has no use yet and is large enough for every one of some kinds."""
    return not parcel.uses and all(KINDS[kind].fits(parcel) for kind in kinds)


def draw_one(rng: np.random.Generator, weights: Mapping[str, float]) -> str:
    """Draw one of some names by their weights, which need not sum to one.

    Args:
        rng: Draws the name.
        weights: Weight of each name; one at least is above 0.
    """
    shares = np.array(list(weights.values()))
    return list(weights)[int(rng.choice(len(shares), p=shares / shares.sum()))]


def choose_places(
    builder: Builder, site: Site, theme: Theme, rng: np.random.Generator
) -> list[Place]:
    """Choose a place for every parcel, larger parcels first.

    Args:
        builder: Builder of the scene.
        site: Site with its parcels.
        theme: Theme that chooses.
        rng: Draws kinds, terraces and the streams of the places.

    Returns:
        Places in the order of the parcels' areas; none of their objects stand yet.
    """
    parcels = sorted(site.parcels, key=lambda parcel: -parcel.width * parcel.depth)
    streams = rng.spawn(len(parcels))
    lifts = Draw(rng)
    places: list[Place] = []
    kinds = _choose_kinds(parcels, theme, rng)
    for parcel, kind, stream in zip(parcels, kinds, streams, strict=True):
        # The terrace becomes the parcel's ground; fences still follow the original outline.
        lifted = parcel
        if KINDS[kind].is_lifted and lifts.chance(theme.terrace_chance):
            lifted = raise_terrace(builder, lifts, parcel)
        ground = Ground(builder, Draw(stream), lifted)
        place, border = KINDS[kind].make(ground), KINDS[kind].border
        if border:
            place = Bordered(place, ground, outer_sides(builder, parcel, parcels), *border)
        places.append(place)
    return places


def _choose_kinds(
    parcels: Sequence[Parcel], theme: Theme, rng: np.random.Generator
) -> Iterator[str]:
    """First the kinds that the plan wants, then the theme's certain ones, then chance."""
    # One of each row, drawn before any parcel is looked at.
    waiting = [str(rng.choice(list(row))) for row in theme.always]
    for parcel in parcels:
        # The larger parcels come first, so that a certain place gets the best ground.
        certain = [*parcel.uses] or [name for name in waiting if KINDS[name].fits(parcel)][:1]
        fitting = {n: w for n, w in theme.others.items() if KINDS[n].fits(parcel)}
        if certain:
            kind = str(rng.choice(certain))
        else:
            kind = draw_one(rng, fitting) if fitting else _ANYWHERE
        if kind in waiting:
            waiting.remove(kind)
        yield kind


def grow_nature(builder: Builder, site: Site, rng: np.random.Generator) -> list[Place]:
    """Begin plants and boats beside the parcels: on slopes and water.

    Args:
        builder: Builder of the scene.
        site: Site with its slopes and waters.
        rng: Draws a stream for each of them.
    """
    streams = rng.spawn(len(site.slopes) + len(site.waters))
    slopes = [Slope(Ground(builder, Draw(streams.pop()), parcel)) for parcel in site.slopes]
    basins = [Basin(builder, Draw(streams.pop()), water) for water in site.waters]
    return [*slopes, *basins]
