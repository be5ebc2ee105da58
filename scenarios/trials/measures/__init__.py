"""Measures of a flight that need no verdict: errors of the estimate, effort, and its track."""
