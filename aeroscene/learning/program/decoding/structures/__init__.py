"""Decoding of partitions: the covers of sites, and the storeys of buildings."""
