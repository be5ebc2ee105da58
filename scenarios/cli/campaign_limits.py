"""Limits of campaigns, which several commands share."""

MOST_TRIALS = 1_000_000
"""Trials of one scene with one vehicle."""
MOST_WORKERS = 10_000
"""Processes of a campaign, including those of a cluster."""
