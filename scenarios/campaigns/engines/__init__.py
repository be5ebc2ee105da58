"""Engines that fly the trials of a campaign: processes, their order of work, and its forecast."""
