"""Tests of the autopilot; most of them fly the real plant."""
