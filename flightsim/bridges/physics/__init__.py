"""Protocols by which external flight stacks exchange motor outputs and sensor data with us."""
