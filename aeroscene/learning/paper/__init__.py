"""The AeroScene paper's method to the letter, as far as it differs from the default preset."""
