"""Composers: one file for each domain, which lays out the places of a scene."""

from aeroscene.corpus.curation.composers.indoor import compose_indoor
from aeroscene.corpus.curation.composers.mixed import compose_mixed
from aeroscene.corpus.curation.composers.outdoor import compose_outdoor

__all__ = ["compose_indoor", "compose_mixed", "compose_outdoor"]
