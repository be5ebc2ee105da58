"""One run of the testbench: what it is asked for, the flight, and the verdict."""
