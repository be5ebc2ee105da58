"""Campaigns: many trials of a pilot, flown in processes that stay warm, kept and scored."""
