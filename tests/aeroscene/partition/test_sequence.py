from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given

from aeroscene.partition import (
    PartitionError,
    SitePartition,
    building_partitions,
    from_sequence,
    site_partition,
    to_sequence,
)
from tests.aeroscene.partition.layouts import FRAME, trees


@given(trees())
def test_a_tree_comes_back_from_its_records_as_it_was(tree):
    site = SitePartition(frame=FRAME, tree=tree, base_m=0.25)
    assert from_sequence(to_sequence(site)) == site


def test_partitions_of_a_scene_come_back_exactly(scene):
    parsed = site_partition(scene)
    found = [s for b in building_partitions(scene) for s in b.storeys]
    for partition in [*found, *([parsed.site] if parsed else [])]:
        records = to_sequence(partition)
        assert from_sequence(records) == partition


def test_a_width_is_named_once_and_used_by_number(scene_42):
    records = to_sequence(site_partition(scene_42).site)
    widths = [r.values[0] for r in records if r.node == "width"]
    assert len(widths) == len(set(widths)) == max(r.strip for r in records)


def test_records_that_are_no_partition_are_refused(scene_42):
    records = to_sequence(site_partition(scene_42).site)
    with pytest.raises(PartitionError, match="ends at record"):
        from_sequence(records[:-1])
    with pytest.raises(PartitionError, match="goes on behind"):
        from_sequence([*records, records[-1]])
    with pytest.raises(PartitionError, match="valid: site, storey"):
        from_sequence(records[1:] if records[0].node == "site" else records[-1:])
    broken = [replace(r, share=r.share / 2) for r in records]
    with pytest.raises(PartitionError, match="shares that sum to 1"):
        from_sequence(broken)
