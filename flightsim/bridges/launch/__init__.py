"""Command lines and parameters by which external flight stacks are started."""
