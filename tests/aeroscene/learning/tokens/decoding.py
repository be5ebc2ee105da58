"""Tokens back as boxes, for the tests of what the channels stand for."""

from __future__ import annotations

import numpy as np

from aeroscene.learning.tokens.batch import slots_of
from aeroscene.learning.tokens.channels import Geometry
from aeroscene.learning.tokens.decode import TreeDecoder
from aeroscene.learning.tokens.examples import Example
from aeroscene.learning.tokens.training_set import TrainingSet


def decoded(known: TrainingSet, example: Example) -> Geometry:
    batch = known.collator.examples([example])
    assert batch.x0 is not None
    boxes = TreeDecoder(known.vocabulary, known.statistics).decode(batch.x0, batch)
    slots = slots_of(example.skeleton, batch)
    heading = boxes.heading[0, slots].numpy()
    return Geometry(
        boxes.center_enu_m[0, slots].numpy(),
        np.arctan2(heading[:, 1], heading[:, 0]),
        boxes.size_m[0, slots].numpy(),
        boxes.openings_m[0, slots].numpy(),
    )
