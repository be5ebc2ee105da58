"""Protocols by which external flight stacks meet our physics."""
