"""Trials: what a flight was like by the truth, and whether that counts as done."""
