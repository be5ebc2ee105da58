"""Surfaces that carry objects, so that a table is set alike on a lawn, on a deck and on a roof."""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.corpus.curation.builder import Attributes, Builder, Placed
from aeroscene.corpus.curation.draw import Draw
from aeroscene.corpus.curation.frame import Frame
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.scene import Vector3


@dataclass(frozen=True, slots=True)
class OpenGround:
    """The surface of a parcel, level or sloped, as a bearing."""

    ground: Ground

    @property
    def builder(self) -> Builder:
        """Builder of the scene."""
        return self.ground.builder

    @property
    def draw(self) -> Draw:
        """Stream of randomness."""
        return self.ground.draw

    def stand(
        self,
        name: str,
        spot: Frame,
        size: Vector3 | None = None,
        *,
        margin: float = 0.04,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object at a spot of the world; see `Platform.stand`.

        Its heading is taken from the spot, and its height from the ground below it.
        """
        at = self.ground.parcel.frame.local(spot.x, spot.y)
        turn = self.ground.facing(spot)
        return self.ground.stand(name, *at, size, turn=turn, margin=margin, look=look)


@dataclass(frozen=True, slots=True)
class Platform:
    """A level face of one object, as a bearing; objects on it become its children."""

    builder: Builder
    draw: Draw
    bearer: Placed
    height: float

    def stand(
        self,
        name: str,
        spot: Frame,
        size: Vector3 | None = None,
        *,
        margin: float = 0.04,
        look: Attributes | None = None,
    ) -> Placed | None:
        """Stand an object at a spot of the world.

        Args:
            name: Category.
            spot: Middle and heading.
            size: Extents; drawn by default.
            margin: Distance to keep from other objects, m.
            look: Attributes.

        Returns:
            The object, or None if it does not fit.
        """
        return self.builder.place(
            name,
            spot,
            size or self.draw.size_of(name),
            base=self.height,
            parent=self.bearer,
            within=self.bearer,
            margin=margin,
            look=look,
        )


Bearing = OpenGround | Platform
"""Something that carries objects."""


def on_top(ground: Ground, bearer: Placed) -> Platform:
    """Upper face of a deck, a path, a container or a table.

    Args:
        ground: Parcel, whose builder and randomness are used.
        bearer: Object whose face it is.
    """
    return Platform(ground.builder, ground.draw, bearer, bearer.top)


def beneath(ground: Ground, canopy: Placed) -> Platform:
    """Give the ground under a canopy, which shelters and therefore owns the objects on it.

    Args:
        ground: Parcel, whose builder and randomness are used.
        canopy: Canopy.
    """
    return Platform(ground.builder, ground.draw, canopy, canopy.base)
