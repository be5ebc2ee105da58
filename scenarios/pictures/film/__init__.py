"""A flight as a film: the vehicle from behind and the views of its cameras, rendered anew."""

from scenarios.pictures.film.film import SUFFIXES, draw_film

__all__ = ["SUFFIXES", "draw_film"]
