"""Parts of a prompt: things with their numbers, relations between them, and the place."""

from __future__ import annotations

from dataclasses import dataclass, field

from aeroscene.scene.catalogue import by_name
from scenarios.generation.prompts.parsing.numbers import MANY, NONE, Number
from scenarios.generation.prompts.vocabulary import categories_of, unmeasurable
from scenarios.generation.prompts.wishes import Count, PromptError, Relation, RelationName

_MANY_COARSE = 5
"""Fewest that are many buildings; of fine objects `MANY.least` are."""


@dataclass(slots=True)
class Mention:
    """A thing in the prompt."""

    thing: str
    number: Number | None
    is_plural: bool
    said: str
    is_subject: bool = False
    """Whether a relation counts it."""

    @property
    def is_none(self) -> bool:
        """Whether there is to be none."""
        return is_none(self.number)

    @property
    def is_explicit(self) -> bool:
        """Whether its number says more than that it is there."""
        return self.number is not None and not self.number.is_article

    @property
    def limits(self) -> tuple[int, int | None]:
        """Least and greatest number."""
        if self.number is None:
            return (2 if self.is_plural else 1), None
        if self.number.is_many:
            return (_MANY_COARSE if _is_coarse(self.thing) else MANY.least), None
        return self.number.least, self.number.most


@dataclass(slots=True)
class Tie:
    """A relation while it is read."""

    relation: RelationName
    said: str
    subject: Mention | None
    hosts: list[str] = field(default_factory=list)
    is_dropped: bool = False
    """Whether its subject was not understood."""

    @property
    def is_complete(self) -> bool:
        """Whether all its hosts are known."""
        return len(self.hosts) == (2 if self.relation == "between" else 1)


@dataclass(slots=True)
class Site:
    """The place of the scene."""

    theme: str = ""
    said: str = ""
    is_weak: bool = True
    thing: str = ""
    """Thing that its word names, if another word names the place."""

    def replaced_by(self, theme: str, said: str) -> None:
        """Require that a second place is the same.

        Raises:
            PromptError: If it is another.
        """
        if theme != self.theme:
            raise PromptError(
                f"prompt asks for two places, {self.said!r} ({self.theme}) and {said!r} ({theme}); "
                "valid: one of the two"
            )


def counts_of(mentions: list[Mention]) -> list[Count]:
    """Counts of the things that no relation counts."""
    return [
        Count(each.thing, *each.limits, said=each.said) for each in mentions if not each.is_subject
    ]


def relation_of(tie: Tie) -> Relation | str:
    """The wish of a complete relation, or why it cannot be measured."""
    subject = tie.subject
    assert subject is not None
    least, most = subject.limits
    wish = Relation(
        subject.thing,
        least,
        most,
        said=f"{subject.said} {tie.said}",
        relation=tie.relation,
        host=tie.hosts[0],
        other=tie.hosts[1] if len(tie.hosts) > 1 else "",
    )
    if (reason := unmeasurable(wish)) is not None:
        return f"{tie.said} ({reason})"
    subject.is_subject = True
    return wish


def is_none(number: Number | None) -> bool:
    """Whether a number says that there is none."""
    return number == NONE


def _is_coarse(thing: str) -> bool:
    return all(by_name()[name].level == "coarse" for name in categories_of(thing))
