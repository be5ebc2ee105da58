"""Hierarchical procedural scenes: streets, blocks, buildings, rooms, furniture, from a seed."""

from aeroscene.corpus.curation.curate import curate_layout, curate_scene, most_landing_areas

__all__ = ["curate_layout", "curate_scene", "most_landing_areas"]
