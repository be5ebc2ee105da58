"""Trials: figures of a flight by the truth, and the verdict on it."""
