"""Pilots by name: ours, the baselines that ship beside it, and a user's own.

A success rate means little without something to compare it with. The baselines are simple methods
from the literature and from common sense, which fly the same trials as every other pilot.
"""
