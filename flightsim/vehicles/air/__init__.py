"""Aerodynamics of a multirotor besides the thrust and drag of its rotors in open air."""
