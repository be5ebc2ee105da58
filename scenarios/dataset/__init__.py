"""Work on the whole corpus: building, counting, checking, looking at it, on every core."""
