"""Kinds of places: one file each, first the structures, then the details."""

from aeroscene.curation.places.flats import Flats
from aeroscene.curation.places.ground import Ground
from aeroscene.curation.places.houses import Houses
from aeroscene.curation.places.market import Market
from aeroscene.curation.places.offices import Offices
from aeroscene.curation.places.park import Park
from aeroscene.curation.places.parking import Parking
from aeroscene.curation.places.yard import Yard

__all__ = ["Flats", "Ground", "Houses", "Market", "Offices", "Park", "Parking", "Yard"]
