"""Composers: one file a domain, each lays out the places of a scene."""

from aeroscene.curation.composers.indoor import compose_indoor
from aeroscene.curation.composers.mixed import compose_mixed
from aeroscene.curation.composers.outdoor import compose_outdoor

__all__ = ["compose_indoor", "compose_mixed", "compose_outdoor"]
