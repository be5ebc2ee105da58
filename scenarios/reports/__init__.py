"""Findings of campaigns for people to read: pages, comparisons, a leaderboard."""
