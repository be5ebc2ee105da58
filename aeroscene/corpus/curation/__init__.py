"""Hierarchical procedural scenes: streets, blocks, buildings, rooms, furniture, from a seed.

The paper's dataset is not public. This grammar curates a corpus of the same size and with the same
averages, which trains the model and serves as its ground truth.
"""

from aeroscene.corpus.curation.curate import curate_layout, curate_scene, most_landing_areas

__all__ = ["curate_layout", "curate_scene", "most_landing_areas"]
