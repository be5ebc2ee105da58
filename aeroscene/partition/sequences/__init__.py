"""Partitions as flat lists of small records, and back without loss."""
