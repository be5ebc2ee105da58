"""Indoor scenes."""

from aeroscene.curation.composers.mixed import compose_mixed as compose_indoor

__all__ = ["compose_indoor"]
