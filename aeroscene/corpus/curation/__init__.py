"""Hierarchical procedural scenes: streets, blocks, buildings, rooms, furniture, from a seed."""

from aeroscene.corpus.curation.curate import curate_scene

__all__ = ["curate_scene"]
