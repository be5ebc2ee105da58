"""Options of the site that words set: density, clutter, difficulty, domain, size, numbers."""

from __future__ import annotations

from dataclasses import dataclass, field

from scenarios.generation.prompts.parsing.lexemes import Lexeme
from scenarios.generation.prompts.parsing.numbers import Number
from scenarios.generation.prompts.wishes import PromptError


@dataclass
class Settings:
    """Options that the words read so far have set."""

    options: dict[str, tuple[object, str]] = field(default_factory=dict)
    """Value of each option, and the words of the prompt that set it."""
    size: tuple[str, str] | None = None
    """Size of the site, such as "small", and the words that set it."""

    def choose(self, option: str, value: object, said: str) -> None:
        """Set an option.

        Args:
            option: Name of the option, such as "density".
            value: Its value.
            said: Words of the prompt.

        Raises:
            PromptError: If it was set to another value before.
        """
        # The same value twice is no contradiction: "a crowded, busy square".
        before, words = self.options.get(option, (value, ""))
        if before != value:
            raise PromptError(
                f"prompt asks for {words!r} and {said!r} ({option} {before} and {value}); "
                "valid: one of the two"
            )
        self.options[option] = (value, f"{words}, {said}" if words else said)

    def count(self, option: str, number: Number | None, said: str) -> bool:
        """Set a number of objects, which is met within a fifth, or of landing areas, at most.

        Args:
            option: "objects" or "areas".
            number: Number before the word; None if there is none.
            said: Words of the prompt.

        Returns:
            True if the number can be asked for. "At least 20 areas" cannot, because these wishes
            have no least number.
        """
        if number is None or number.most is None or not number.n:
            return False
        self.choose(option, number.n, said)
        return True

    def size_by(self, lexeme: Lexeme, following: Lexeme | None) -> bool:
        """Set the size of the site.

        Args:
            lexeme: Word for a size.
            following: Lexeme after it; None at the end.

        Returns:
            True if the word is about the site. A thing has no size that can be asked for.

        Raises:
            PromptError: If another size was set.
        """
        noun = following.value if following is not None and following.kind == "noun" else None
        if noun is not None and (not noun.place or noun.is_plural):
            return False
        if self.size is not None and self.size[0] != lexeme.value:
            raise PromptError(
                f"prompt asks for {self.size[1]!r} and {lexeme.said!r}; valid: one of the two"
            )
        words = f"{self.size[1]}, " if self.size is not None else ""
        self.size = (lexeme.value, f"{words}{lexeme.said}")
        return True
