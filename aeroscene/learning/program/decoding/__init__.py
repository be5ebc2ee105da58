"""From a program to its scene."""
