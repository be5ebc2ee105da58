"""Every numeric option of every command has a range, which help names and the parser holds."""

import math
import re
from dataclasses import fields, is_dataclass
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import pytest

from aeroscene.metrics.appearance.frechet import LEAST_PICTURES
from aeroscene.ranges import Range, ranges_of
from flightsim.testbench import MAX_INSTANCES
from scenarios.cli import campaign, evaluate
from scenarios.cli.main import _COMMANDS, _module, main
from scenarios.cli.option_faults import outputs_of
from tests.scenarios.in_process import in_process

REQUIRED = {
    "fly": ("--out", "{tmp}", "--trial", "0"),
    "campaign": ("--out", "{tmp}"),
    "export": ("--out", "{tmp}", "--to", "glb"),
    "images": ("--out", "{tmp}"),
    "layouts": ("pyproject.toml",),
    "replay": ("x.rrd",),
    "compare": ("a", "b"),
    "report": ("a",),
}
"""What a command line needs besides the option that is tested."""


class Option(NamedTuple):
    command: tuple[str, ...]
    """Words of the command."""
    owner: type
    """Dataclass that has the option."""
    field: str

    @property
    def flag(self):
        return f"--{self.field.replace('_', '-')}"

    @property
    def range(self) -> Range:
        return ranges_of(self.owner)[self.field]

    def args(self, tmp, *value):
        more = [word.format(tmp=tmp / "out") for word in REQUIRED.get(self.command[0], ())]
        if self.flag in more:
            at = more.index(self.flag)
            del more[at : at + 2]
        return [*self.command, *more, *value]

    def __str__(self):
        return " ".join((*self.command, self.flag))


def options_of(owner: type, command: tuple[str, ...]):
    """Options with their types, without what stands around these; subcommands are followed."""
    for field in fields(owner):
        hint = get_type_hints(owner, include_extras=True)[field.name]
        commands = [choice for choice in get_args(hint) if is_options(plain(choice))]
        if is_options(plain(hint)):
            yield from options_of(plain(hint), command)
        elif commands:
            for choice in commands:
                (name,) = (m.name for m in choice.__metadata__ if hasattr(m, "prefix_name"))
                yield from options_of(plain(choice), (*command, name))
        else:
            yield Option(command, owner, field.name), hint


def is_options(hint):
    return isinstance(hint, type) and is_dataclass(hint)


def plain(hint):
    """A type without what annotates it."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def parts_of(hint) -> set[Any]:
    return {hint}.union(*map(parts_of, get_args(hint)))


EVERY = [
    pair
    for name, options in _COMMANDS.items()
    for pair in options_of(getattr(_module(name), options), (name,))
]
NUMERIC = [option for option, hint in EVERY if {int, float} & parts_of(hint)]
WRITTEN = [option for option, _ in EVERY if option.field in outputs_of(option.owner)]
HELP: dict[tuple[str, ...], str] = {}


@pytest.fixture
def no_work(monkeypatch):
    """No command begins its work."""

    def run(_):
        raise AssertionError("the command has begun")

    for name in _COMMANDS:
        monkeypatch.setattr(_module(name), "run", run)


def test_all_options_are_looked_at():
    assert len(EVERY) > 170
    assert len(NUMERIC) > 50
    assert {option.command for option in NUMERIC} >= {
        *(("sitl",), ("fly",), ("campaign",), ("generate",), ("train",), ("evaluate",)),
        *(("dataset", name) for name in ("build", "stats", "validate", "show", "unpack")),
        *(("bench", name) for name in ("sim", "worlds", "vehicles", "generate", "control")),
    }


@pytest.mark.parametrize("option", NUMERIC, ids=str)
def test_a_number_out_of_its_range_is_one_line_before_any_work(tmp_path, capsys, no_work, option):
    valid = option.range
    outside = ["nan", "inf"] if float in parts_of(_hint(option)) else []
    outside.append(_text(valid.low if valid.is_above else valid.low - 1, option))
    if valid.high < math.inf:
        outside.append(_text(valid.high + 1, option))
    for value in outside:
        args = option.args(tmp_path, f"{option.flag}={value}")
        status, out, err = in_process(capsys, *args)
        assert (status, out, err.count("\n")) == (2, "", 1), (value, err)
        said = re.escape(f" is out of range; valid: {valid}")
        name = option.field.replace("_", "-")
        help_is = r"(?:; see aeroscene [a-z ]+ --help)?"
        assert re.fullmatch(rf"aeroscene [a-z ]+: error: {name} \S+{said}{help_is}\n", err), err


@pytest.mark.parametrize("option", NUMERIC, ids=str)
def test_help_names_the_range_of_each_number(capsys, option):
    if option.command not in HELP:
        with pytest.raises(SystemExit):
            main([*option.command, "--help"])
        plain = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out)
        HELP[option.command] = " ".join(re.sub("[│╭╰─╮╯]", " ", plain).split())
    _, _, after = HELP[option.command].partition(f" {option.flag} ")
    text = re.split(r" --[a-z-]+ (?:INT|FLOAT|STR|PATH|\{)", after)[0]
    assert f"Valid: {option.range}." in text, after[:300]


@pytest.mark.parametrize("option", WRITTEN, ids=str)
def test_an_output_that_cannot_be_written_is_one_line_before_any_work(
    tmp_path, capsys, no_work, option
):
    is_folder = "Folder" in type(outputs_of(option.owner)[option.field]).__name__
    suffix = next(iter(getattr(outputs_of(option.owner)[option.field], "suffixes", ())), ".x")
    file = tmp_path / "file"
    file.touch()
    wrong = [file / f"below{suffix}", file] if is_folder else [file / f"below{suffix}"]
    if not is_folder:
        wrong.append(tmp_path / f"folder{suffix}")
        wrong[-1].mkdir()
    for path in wrong:
        status, out, err = in_process(capsys, *option.args(tmp_path, f"{option.flag}={path}"))
        assert (status, out, err.count("\n")) == (2, "", 1), err
        assert re.match(rf"aeroscene [a-z ]+: error: {option.field} '{path}'.*; valid: ", err), err


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["--objects", "2600"], "objects 2600 is out of range; valid: 20 to 2500"),
        (["--outline", "450,300"], "outline 450.0 is out of range; valid: 15 to 400 m"),
        (["--outline", "20,nan"], "outline is '20,nan'; valid: EAST,NORTH in metres"),
        (["--areas", "900"], "areas 900 is out of range; valid: 1 to 200"),
        (["--areas", "small=900"], "areas small 900 is out of range; valid: 0 to 200"),
        (["--of", "2", "--count", "3", "--worst-for", "demo"], "of is 2 beside count 3"),
        (["--density", "1", "--objects", "30"], "density is 1 beside objects 30; valid: one"),
        (["--redo", "42", "--region", "1,2"], "region is '1,2'; valid: X0,Y0,X1,Y1"),
        (["--out", "pyproject.toml"], "out 'pyproject.toml' is a file; valid: a folder"),
    ],
)
def test_generate_refuses_wishes_before_it_loads_the_model(capsys, monkeypatch, args, says):
    def loaded():
        raise AssertionError("PyTorch is loaded")

    monkeypatch.setattr("scenarios.cli.generate.require_torch", loaded)
    status, out, err = in_process(capsys, "generate", *args)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"aeroscene generate: error: {says}")


def test_bounds_that_are_written_twice_are_equal():
    assert campaign._MOST_INSTANCE == MAX_INSTANCES - 1
    assert evaluate._LEAST_SCENES == LEAST_PICTURES


@pytest.mark.parametrize(
    ("valid", "inside", "outside", "says"),
    [
        (Range(1, 3), (1, 3), (0, 4, math.nan), "1 to 3"),
        (Range(0.5, unit="s"), (0.5, 1e300), (0.4, math.inf, math.nan), "0.5 s or more"),
        (Range(0, is_above=True), (1e-9,), (0, -1, math.inf), "above 0"),
        (Range(0, is_above=True, word="max"), (3,), (0, math.inf), "above 0, or max"),
        (Range(0, 2, "m", is_above=True), (2,), (0, 2.1), "above 0, at most 2 m"),
    ],
)
def test_a_range_has_its_ends_and_no_infinity(valid, inside, outside, says):
    assert all(value in valid for value in inside)
    assert not any(value in valid for value in outside)
    assert str(valid) == says


def _hint(option):
    return get_type_hints(option.owner, include_extras=True)[option.field]


def _text(value, option):
    return str(float(value)) if float in parts_of(_hint(option)) else str(int(value))
