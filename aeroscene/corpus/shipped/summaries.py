"""What there is to know of every scene without opening it, as columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

import numpy as np

from aeroscene.corpus.corpus import scene_split
from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from aeroscene.corpus.summary import SceneSummary
from aeroscene.scene import SceneDomain

_DOMAINS: tuple[SceneDomain, ...] = get_args(SceneDomain)
_COUNTS = ("n_coarse", "n_fine", "n_small", "n_medium", "n_large", "n_perching")


def encode_summaries(summaries: Sequence[SceneSummary]) -> bytes:
    """Summaries of scenes 0, 1, 2 ... as compressed bytes."""
    writer = ColumnWriter()
    writer.add_plain([summary.scene_id for summary in summaries])
    writer.add(np.array([_DOMAINS.index(summary.domain) for summary in summaries], np.int64))
    for name in _COUNTS:
        writer.add(np.array([getattr(summary, name) for summary in summaries], np.int64))
    return writer.to_bytes()


def decode_summaries(data: bytes) -> tuple[SceneSummary, ...]:
    """The summaries, each with its split of the dataset."""
    reader = ColumnReader(data)
    scene_ids = reader.take_plain(list[str])
    domains = [_DOMAINS[number] for number in reader.take().tolist()]
    counts = zip(*(reader.take().tolist() for _ in _COUNTS), strict=True)
    return tuple(
        SceneSummary(
            index=index,
            scene_id=scene_id,
            split=scene_split(index),
            domain=domain,
            n_objects=row[0] + row[1],
            **dict(zip(_COUNTS, row, strict=True)),
        )
        for index, (scene_id, domain, row) in enumerate(
            zip(scene_ids, domains, counts, strict=True)
        )
    )
