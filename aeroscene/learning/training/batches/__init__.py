"""Where a training's batches come from: fixed scenes, or the grammar's, streamed without end.

Batch k depends on the seed and on k alone, whichever way it is made.
"""
