"""How external flight stacks are started, and with which parameters."""
