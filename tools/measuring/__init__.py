"""Benchmarks of the planner, the estimator and landing: `python tools/bench.py`."""
