"""Districts: blocks along streets that meet, each filled by a program of its own."""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

if TYPE_CHECKING:
    from aeroscene.corpus.districts.compose import compose_district
    from aeroscene.corpus.districts.request import DistrictError, DistrictRequest

    __all__ = ["DistrictError", "DistrictRequest", "compose_district"]
else:
    __getattr__, __dir__ = public_names(__name__, __file__)
