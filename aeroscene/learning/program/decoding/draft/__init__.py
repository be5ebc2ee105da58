"""A scene under construction: its objects, their neighbours, and their possible supports."""

from aeroscene.learning.program.decoding.draft.draft import Draft, Given

__all__ = ["Draft", "Given"]
