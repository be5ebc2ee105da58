"""Parallel work on the whole corpus: building, counting, checking, unpacking and shipping."""
