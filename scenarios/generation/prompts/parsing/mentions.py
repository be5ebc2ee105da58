"""Parts of a prompt: things with their numbers, relations between them, and the place."""

from __future__ import annotations

from dataclasses import dataclass, field

from aeroscene.scene.catalogue import by_name
from scenarios.generation.prompts.parsing.numbers import MANY, NONE, Number
from scenarios.generation.prompts.vocabulary import categories_of, unmeasurable
from scenarios.generation.prompts.wishes import Count, PromptError, Relation, RelationName

_MANY_COARSE = 5
"""Fewest coarse objects, such as buildings, that are "many"; for fine ones it is `MANY.least`."""


@dataclass(slots=True)
class Mention:
    """A thing in the prompt."""

    thing: str
    number: Number | None
    is_plural: bool
    said: str
    is_subject: bool = False
    """True if a relation counts the thing, so that no count of its own is needed."""

    @property
    def is_none(self) -> bool:
        """True if the prompt asks for none of the thing."""
        return is_none(self.number)

    @property
    def is_explicit(self) -> bool:
        """True if there is a number, and it is more than an article."""
        return self.number is not None and not self.number.is_article

    @property
    def limits(self) -> tuple[int, int | None]:
        """Least and greatest number; None as the greatest sets no limit."""
        # A bare plural asks for at least two, a bare singular for one.
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
    """True if its subject was not understood."""

    @property
    def is_complete(self) -> bool:
        """True if all hosts are known: two for "between", else one."""
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
        """Refuse a second place, unless it has the same theme.

        Args:
            theme: Theme of the second place.
            said: Its words in the prompt.

        Raises:
            PromptError: If it is another.
        """
        if theme != self.theme:
            raise PromptError(
                f"prompt asks for two places, {self.said!r} ({self.theme}) and {said!r} ({theme}); "
                "valid: one of the two"
            )


def counts_of(mentions: list[Mention]) -> list[Count]:
    """Return the counts of the things that no relation counts.

    Args:
        mentions: Things of the prompt, after `relation_of` has marked its subjects.
    """
    return [
        Count(each.thing, *each.limits, said=each.said) for each in mentions if not each.is_subject
    ]


def relation_of(tie: Tie) -> Relation | str:
    """Return the wish of a relation, or the words and the reason why it cannot be measured.

    Args:
        tie: Complete relation; its subject is marked as counted if the relation can be measured.
    """
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
    # Its subject then keeps a count of its own, so that part of the wish is still met.
    if (reason := unmeasurable(wish)) is not None:
        return f"{tie.said} ({reason})"
    subject.is_subject = True
    return wish


def is_none(number: Number | None) -> bool:
    """Return true if a number asks for none: "no", "without"."""
    return number == NONE


def _is_coarse(thing: str) -> bool:
    return all(by_name()[name].level == "coarse" for name in categories_of(thing))
