"""What a ground station can read about the vehicle instead of having to know it."""

from flightsim.mavlink.metadata.documents import MetadataService
from flightsim.mavlink.metadata.packed_parameters import PACKED_PARAMETERS, PackedParameters

__all__ = ["PACKED_PARAMETERS", "MetadataService", "PackedParameters"]
