"""The parser's second step: it joins numbers to things, and things to their hosts.

`Clauses` reads lexemes from left to right and keeps what is still open: a number that waits for its
thing, a relation that waits for its host or its subject, and a word for the place that a stronger
word may replace. Nothing is dropped silently. Whatever stays open at the end of a clause goes to
`unknown`, which the user sees as "not understood".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from scenarios.generation.prompts.parsing.lexemes import Lexeme
from scenarios.generation.prompts.parsing.lexicon import Noun
from scenarios.generation.prompts.parsing.mentions import Mention, Site, Tie, is_none
from scenarios.generation.prompts.parsing.numbers import A, Number
from scenarios.generation.prompts.parsing.settings import Settings
from scenarios.generation.prompts.wishes import COUNTS, PromptError, spoken

_ABOUT_PLACE = ("inside", "on", "near", "next_to", "along")
"""Relations whose host may name the place of the scene: a house in a park, bikes along the quay."""


@dataclass
class Clauses:
    """State of the parser after the lexemes that it has read so far."""

    site: Site = field(default_factory=Site)
    mentions: list[Mention] = field(default_factory=list)
    ties: list[Tie] = field(default_factory=list)
    settings: Settings = field(default_factory=Settings)
    unknown: list[str] = field(default_factory=list)
    _number: Number | None = None
    _number_said: str = ""
    _is_carried: bool = False
    """True if that number was used for a thing already, as in "no cars and trees"."""
    _is_after_place: bool = False
    _place_thing: str = ""
    """Thing that the last word for the place names, if it is used as a host."""
    _is_modified: bool = False
    """True if the word before is a place that modifies the next one, as in "school library"."""
    _was_modified: bool = False
    _last: Mention | None = None
    """Thing that is the subject of a relation that follows."""
    _is_last_unknown: bool = False
    _tie: Tie | None = None
    """Relation that waits for a host."""
    _fronted: Tie | None = None
    """Relation that waits for its subject: "behind the house a garden"."""
    _is_in_head: bool = True
    """True while the place is still being named: until the first "with"."""

    def read(self, lexemes: Sequence[Lexeme]) -> None:
        """Read a whole prompt; afterwards the public fields hold its parts.

        Args:
            lexemes: Lexemes of the prompt, in order.

        Raises:
            PromptError: If it contradicts itself.
        """
        # One lexeme ahead is enough: it tells a modifier ("harbour street") from a noun.
        for index, lexeme in enumerate(lexemes):
            following = lexemes[index + 1] if index + 1 < len(lexemes) else None
            self._read(lexeme, following)
        self._end_clause()

    def _read(self, lexeme: Lexeme, following: Lexeme | None) -> None:
        kind = lexeme.kind
        if kind == "noun":
            self._read_noun(lexeme, following)
        elif kind == "number":
            self._read_number(lexeme)
        elif kind in {"option", "size", "amount"}:
            self._read_setting(lexeme, following)
        elif kind == "relation":
            self._read_relation(lexeme)
        elif kind == "reversed":
            self._read_reversed(lexeme)
        elif kind == "pronoun":
            self._read_pronoun()
        elif kind == "and":
            self._read_and(lexeme)
        elif kind == "with":
            # "with" ends the naming of the place: what follows is in it.
            self._drop_number()
            self._drop(self._tie)
            self._tie, self._is_in_head, self._is_after_place = None, False, False
        elif kind == "clause":
            self._end_clause()
        else:
            self.unknown.append(lexeme.said)
            self._is_last_unknown = True

    def _read_number(self, lexeme: Lexeme) -> None:
        number: Number = lexeme.value
        if is_none(self._number) and not self._is_carried and number.is_article:
            return  # "without a car": the article adds nothing
        self._drop_number()
        if fault := COUNTS.fault("prompt: number", number.n or 0):
            raise PromptError(fault)
        self._number, self._number_said, self._is_carried = number, lexeme.said, False

    def _read_setting(self, lexeme: Lexeme, following: Lexeme | None) -> None:
        """Read a word that sets an option of the site; "not crowded" sets none."""
        number, words = self._number, f"{self._number_said} {lexeme.said}"
        is_negated = is_none(number)
        if lexeme.kind == "size":
            if is_negated or not self.settings.size_by(lexeme, following):
                self.unknown.append(words if is_negated else lexeme.said)
        elif lexeme.kind == "amount":
            if not self.settings.count(lexeme.value, number, words):
                self.unknown.append(words if number is not None else lexeme.said)
        elif is_negated:
            self.unknown.append(words)
        else:
            option, value = lexeme.value
            self.settings.choose(option, value, lexeme.said)
        if is_negated or lexeme.kind == "amount":
            self._number = None

    def _read_pronoun(self) -> None:
        """Read "it" in "in front of it": the thing named last, except the relation's subject."""
        tie = self._tie
        if tie is None:
            return
        named = [each for each in self.mentions if each is not tie.subject and not each.is_none]
        if not named:
            self._close(said_only=True)
        else:
            self._read_host(Noun(named[-1].thing), named[-1].said)

    def _read_and(self, lexeme: Lexeme) -> None:
        # "no cars and trees" wants neither; "two cafes and trees" has no number for the trees.
        if not is_none(self._number):
            self._drop_number()
        if lexeme.said != ",":
            self._last = self._last if self._tie is not None else None
        self._is_last_unknown = self._is_after_place = False

    def _end_clause(self) -> None:
        self._drop_number()
        self._drop(self._tie)
        self._drop(self._fronted)
        self._number = self._last = self._tie = self._fronted = None
        self._is_last_unknown = self._is_after_place = False

    def _drop_number(self) -> None:
        """Report a number that nothing followed as not understood."""
        number = self._number
        if (
            number is not None
            and not number.is_article
            and not (number.most == 0 and self._is_carried)
        ):
            self.unknown.append(self._number_said)
        self._number = None

    def _drop(self, tie: Tie | None) -> None:
        """Report a relation that lacks its subject or its host as not understood."""
        if tie is not None:
            self.unknown.append(tie.said)

    def _read_relation(self, lexeme: Lexeme) -> None:
        self._drop_number()
        self._drop(self._tie)
        # "a unicorn behind the house": the unknown word is the subject, not the thing before it.
        subject = None if self._is_last_unknown else self._last
        self._tie = Tie(lexeme.value, lexeme.said, subject, is_dropped=self._is_last_unknown)
        self._is_last_unknown = False

    def _read_reversed(self, lexeme: Lexeme) -> None:
        """Read "surrounded by" in "a pond surrounded by trees": the host comes before the thing."""
        self._drop_number()
        host = self._last.thing if self._last is not None else self._place_thing
        if self._is_last_unknown or not host:
            self.unknown.append(lexeme.said)
        else:
            self._drop(self._fronted)
            self._fronted = Tie(lexeme.value, f"{lexeme.said} {spoken(host)}", None, [host])

    def _read_noun(self, lexeme: Lexeme, following: Lexeme | None) -> None:
        noun: Noun = lexeme.value
        is_modifier = following is not None and following.kind == "noun"
        self._is_modified &= bool(noun.place)
        self._is_last_unknown = False
        # An open relation takes the noun first, then the place, and a count is the usual case.
        if self._tie is not None and not (is_modifier and self._tie.subject is not None):
            self._read_host(noun, lexeme.said)
        elif noun.place and self._names_place(noun, is_modifier=is_modifier):
            self._read_place(noun, lexeme.said, is_modifier=is_modifier)
        elif noun.thing and (not is_modifier or noun.is_plural):
            self._mention(noun, lexeme.said)
        else:
            self.unknown.append(lexeme.said)

    def _names_place(self, noun: Noun, *, is_modifier: bool) -> bool:
        """Return true if a word for a place, which may name a thing too, means the place here."""
        if is_none(self._number):
            return False  # "no harbour" can only mean a thing
        is_counted = self._number is not None and self._number.n not in {None, 1}
        if noun.thing and not is_modifier and (is_counted or noun.is_plural):
            return False
        if noun.is_weak or self.site.is_weak or noun.place == self.site.theme:
            return True
        return not noun.thing and self._is_in_head

    def _read_place(self, noun: Noun, said: str, *, is_modifier: bool = False) -> None:
        site = self.site
        if self._is_modified and noun.place != site.theme and not (noun.is_weak or site.is_weak):
            # "a school library" is a library.
            self.unknown.append(f"{site.said} (a second place)")
            self.site = site = Site()
        self._was_modified, self._is_modified = self._is_modified, is_modifier
        if not site.theme or (site.is_weak and not noun.is_weak):
            words = self._leave(site, said)
            thing = noun.thing if noun.is_weak else ""
            self.site = Site(noun.place, words, noun.is_weak, thing)
        elif noun.is_weak:
            # "harbour street": a harbour, which has a street.
            if noun.thing and noun.place != site.theme:
                self.mentions.append(Mention(noun.thing, None, is_plural=False, said=said))
            elif self._was_modified or noun.place == site.theme:
                site.said = f"{site.said} {said}"
            else:
                self.unknown.append(f"{said} (a second place)")
        elif noun.place == site.theme:
            site.said = f"{site.said}, {said}"
        else:
            site.replaced_by(noun.place, said)
        self._last, self._is_after_place, self._place_thing = None, True, noun.thing
        if self._number is not None and self._number.n in {None, 1}:
            self._number = None

    def _leave(self, site: Site, said: str) -> str:
        """Use a weak word for the place otherwise, and return the words of the stronger one."""
        if site.thing:
            self.mentions.append(Mention(site.thing, None, is_plural=False, said=site.said))
        elif site.theme and self._was_modified:
            return f"{site.said} {said}"
        elif site.theme:
            self.unknown.append(f"{site.said} (a second place)")
        return said

    def _mention(self, noun: Noun, said: str) -> Mention:
        number = self._number
        words = said if number is None or number.is_article else f"{self._number_said} {said}"
        mention = Mention(noun.thing, number, noun.is_plural, words)
        self.mentions.append(mention)
        # "no" also holds for the next things: "no cars and trees". Other numbers do not.
        self._number, self._is_carried = (number, True) if is_none(number) else (None, False)
        self._last, self._is_after_place = mention, False
        if self._fronted is not None:
            self._fronted.subject = mention
            self.ties.append(self._fronted)
            self._fronted = None
        return mention

    def _read_host(self, noun: Noun, said: str) -> None:
        tie = self._tie
        assert tie is not None
        is_place = bool(noun.place) and tie.relation in _ABOUT_PLACE and not noun.is_plural
        if is_place and self.site.is_weak and not (noun.is_weak and self.site.theme):
            is_about_place = tie.relation != "along"
            self._read_place(noun, f"{tie.said} {said}" if is_about_place else said)
            if is_about_place:
                self._tie = None
                return
        number, number_said = self._number, self._number_said
        words = said if number is None or number.is_article else f"{number_said} {said}"
        tie.said = f"{tie.said} {words}"
        self._number = None
        if not noun.thing:
            self._close(said_only=True)
            return
        tie.hosts.append(noun.thing)
        host = Mention(noun.thing, number, noun.is_plural, words)
        # "next to two cafes" asks for two cafes; "next to a cafe" needs no count of its own, since
        # the relation cannot hold without one.
        if host.is_explicit:
            self.mentions.append(host)
        elif tie.is_dropped or is_none(tie.subject.number if tie.subject else None):
            self.mentions.append(Mention(noun.thing, A, is_plural=False, said=words))
        # "between two houses" names both hosts with one word.
        if tie.relation == "between" and (noun.is_plural or host.is_explicit):
            tie.hosts = [noun.thing, noun.thing]
        if tie.is_complete:
            self._close()

    def _close(self, *, said_only: bool = False) -> None:
        """End the relation that is being read."""
        tie, self._tie = self._tie, None
        assert tie is not None
        if said_only or tie.is_dropped:
            self.unknown.append(tie.said)
        elif tie.subject is None and self._is_after_place:
            # "a village by the sea": the place has it.
            self.mentions.append(Mention(tie.hosts[0], A, is_plural=False, said=tie.said))
        elif tie.subject is None:
            # "behind the house a garden": the subject comes next.
            self._drop(self._fronted)
            self._fronted = tie
        else:
            self.ties.append(tie)
            self._last = tie.subject
