"""Batches of a training: from fixed scenes, or from scenes that the grammar makes without end.

Batch k depends on the seed and on k alone in both cases, so that a training can be resumed exactly.
"""
