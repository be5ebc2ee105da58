"""Parallel work on the whole corpus: building, counting, checking and viewing."""
