"""The coarse layout of sites and storeys as partition trees, read off scenes and built again.

A list of boxes can have gaps and overlaps. A tree that divides a rectangle cannot, because both
sides of a cut share it. `site_partition` and `building_partitions` read trees off a scene, and
`build_site` and `build_storeys` are their inverses. `to_sequence` and `from_sequence` turn trees
into the records that a model learns.
"""

from aeroscene.partition.sequences.read import from_sequence
from aeroscene.partition.sequences.record import Record
from aeroscene.partition.sequences.write import to_sequence
from aeroscene.partition.sites.parse import ParsedSite, site_partition
from aeroscene.partition.sites.site import Cover, SitePartition, build_site
from aeroscene.partition.storeys.build import BuildingPart, build_storeys
from aeroscene.partition.storeys.parse import (
    ParsedBuilding,
    building_partitions,
    storey_partitions,
)
from aeroscene.partition.storeys.storey import Border, Segment, StoreyPartition, storey_lines
from aeroscene.partition.tree import PartitionError

__all__ = [
    "Border",
    "BuildingPart",
    "Cover",
    "ParsedBuilding",
    "ParsedSite",
    "PartitionError",
    "Record",
    "Segment",
    "SitePartition",
    "StoreyPartition",
    "build_site",
    "build_storeys",
    "building_partitions",
    "from_sequence",
    "site_partition",
    "storey_lines",
    "storey_partitions",
    "to_sequence",
]
