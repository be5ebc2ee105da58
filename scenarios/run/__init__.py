"""One run of the testbench: its configuration, the flight and the verdict."""
