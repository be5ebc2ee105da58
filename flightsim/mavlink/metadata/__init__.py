"""Metadata: documents from which a ground station learns parameters and events of the vehicle."""

from flightsim.mavlink.metadata.documents import MetadataService
from flightsim.mavlink.metadata.packed_parameters import PACKED_PARAMETERS, PackedParameters

__all__ = ["PACKED_PARAMETERS", "MetadataService", "PackedParameters"]
