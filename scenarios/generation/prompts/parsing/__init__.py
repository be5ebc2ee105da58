"""A small parser of English prompts, without a network: words to lexemes, lexemes to wishes."""

from scenarios.generation.prompts.parsing.reading import read_prompt

__all__ = ["read_prompt"]
