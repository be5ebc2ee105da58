"""Kinds of places: one file each, first the structures, then the details."""

from aeroscene.corpus.curation.places.construction import Construction
from aeroscene.corpus.curation.places.depot import Depot
from aeroscene.corpus.curation.places.flats import Flats
from aeroscene.corpus.curation.places.ground import Ground
from aeroscene.corpus.curation.places.houses import Houses
from aeroscene.corpus.curation.places.market import Market
from aeroscene.corpus.curation.places.offices import Offices
from aeroscene.corpus.curation.places.park import Park
from aeroscene.corpus.curation.places.parking import Parking
from aeroscene.corpus.curation.places.school import School
from aeroscene.corpus.curation.places.station import Station
from aeroscene.corpus.curation.places.terraces import Terraces
from aeroscene.corpus.curation.places.waterfront import Waterfront
from aeroscene.corpus.curation.places.yard import Yard

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
