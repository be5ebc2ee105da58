"""A small parser of English prompts, without a network: words to lexemes, lexemes to wishes.

A parser of phrases is predictable: equal words give equal wishes, at once and on every machine, and
every word that it does not understand is reported. It reads texts in one pass from left to right,
because wishes are lists of noun phrases and seldom have a deeper grammar.
"""

from scenarios.generation.prompts.parsing.prompt_reader import read_prompt

__all__ = ["read_prompt"]
