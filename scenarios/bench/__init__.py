"""Benchmarks that run the real stack on this machine: speed, scene models, control.

Each benchmark is a module with a function `rows(cfg, on_progress)`, which yields a `Row` for each
figure. CPU time is preferred to wall time, because it holds on a busy machine too. Targets are part
of a row, so that the exit status says whether all are met.
"""
