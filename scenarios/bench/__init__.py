"""Benchmarks of this machine that run the real stack."""
