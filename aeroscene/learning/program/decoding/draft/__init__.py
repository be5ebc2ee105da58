"""A scene in the making: its objects so far, who stands near them, and what may bear them."""

from aeroscene.learning.program.decoding.draft.draft import Draft, Given

__all__ = ["Draft", "Given"]
