"""Kinds of places: one file each, first the structures, then the details."""

from aeroscene.curation.places.construction import Construction
from aeroscene.curation.places.depot import Depot
from aeroscene.curation.places.flats import Flats
from aeroscene.curation.places.ground import Ground
from aeroscene.curation.places.houses import Houses
from aeroscene.curation.places.market import Market
from aeroscene.curation.places.offices import Offices
from aeroscene.curation.places.park import Park
from aeroscene.curation.places.parking import Parking
from aeroscene.curation.places.school import School
from aeroscene.curation.places.station import Station
from aeroscene.curation.places.terraces import Terraces
from aeroscene.curation.places.waterfront import Waterfront
from aeroscene.curation.places.yard import Yard

__all__ = [
    "Construction",
    "Depot",
    "Flats",
    "Ground",
    "Houses",
    "Market",
    "Offices",
    "Park",
    "Parking",
    "School",
    "Station",
    "Terraces",
    "Waterfront",
    "Yard",
]
