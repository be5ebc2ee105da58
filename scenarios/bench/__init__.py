"""How fast this is on this machine: benchmarks that fly for real."""
