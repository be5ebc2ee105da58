"""Parts of `fuzz_mavlink.py`: hostile frames, and the vehicles that must bear them."""
