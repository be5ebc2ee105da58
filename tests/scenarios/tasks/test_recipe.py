"""Recipes: TOML in, one line about whatever is wrong with it."""

import pytest

from scenarios.tasks.recipe import Recipe, RecipeError, read_recipe, recipe_from


def test_what_a_file_does_not_name_keeps_its_default(tmp_path):
    path = tmp_path / "recipe.toml"
    path.write_text('wind_mps = [3, 8.5]\ntraffic = ["none", "people=2"]\nstart = ["area"]\n')
    recipe = read_recipe(path)
    assert recipe == Recipe(wind_mps=(3, 8.5), traffic=("none", "people=2"), start=("area",))
    assert recipe_from(recipe.to_plain()) == recipe


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("wind = 3", "recipe: 'wind' is unknown; valid: seed, start, "),
        ("wind_mps = [5, 1]", r"wind_mps \[5.*\] is no range; valid: \[LOW, HIGH\] from 0 m/s"),
        ("wind_mps = 5", "recipe: wind_mps is 5: expected `array`, got `int`"),
        ("wind_mps = [0, 1000]", "recipe: wind"),
        ('gnss = ["none"]', r"recipe: gnss is \['none'\]: invalid enum value 'none'"),
        ("map = []", "recipe: map has 0 values; valid: 1 to 100"),
        ('turbulence = ["wild"]', "recipe: turbulence 'wild'"),
        ('traffic = ["horses=1"]', "recipe: traffic"),
        (
            "time_limit_s = 0",
            "recipe: time_limit_s 0.0 is out of range; valid: above 0, at most 240",
        ),
        ('ends = "both"', "recipe: ends is 'both'"),
        ('goals = ["word"]', "recipe: goals is "),
        ('goals = ["naming"]\ntarget = "any"', "target 'any' has no texts; valid: landing"),
        ('failures = ["gnss"]', "recipe: failures 'gnss' is not valid"),
        ('failures = ["gnss=off@8:2"]', "8:2 is no range"),
        ('failures = ["wing=off@1"]', "part 'wing' is unknown"),
        ('failures = ["motor99=off@1"]', "part 'motor99' is unknown"),
        ("navigation_within = 0.5", "recipe: navigation_within 0.5 is out of range; valid: 1 or"),
        ("draws = 0", "recipe: draws 0 is out of range; valid: 1 to 100"),
        ("seed = -1", "recipe: seed -1 is out of range"),
        ("seed =", "is no TOML"),
        ('light = ["dusk, fgo"]', "recipe: light: 'fgo' is unknown"),
        ('light = "dusk"', "recipe: light is 'dusk': expected `array`, got `str`"),
        ('season = ["monsoon"]', r"recipe: season is \['monsoon'\]: invalid enum value"),
        ("draws = 1000000000", "recipe: draws 1000000000 is out of range; valid: 1 to 100"),
        (f"seed = {10**30}", f"recipe: seed {10**30} is out of range; valid: 0 to {2**63 - 1}"),
        (f"seed = {'9' * 5000}", "it is no TOML: Exceeds the limit"),
        (f"draws = {'[' * 50_000}", "it is nested too deeply"),
        ("#" * 300_000, "holds more than 256 KiB; valid: at most that"),
    ],
)
def test_a_recipe_that_is_wrong_is_refused_in_one_line(tmp_path, text, says):
    path = tmp_path / "recipe.toml"
    path.write_text(text)
    with pytest.raises(RecipeError, match=says) as caught:
        read_recipe(path)
    assert "\n" not in str(caught.value)


def test_a_recipe_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RecipeError, match=r"none.toml': No such file or directory"):
        read_recipe(tmp_path / "none.toml")


def test_any_motor_of_any_vehicle_may_fail():
    words = ("motor4=off@3", "motor6=slow@1:2")
    assert recipe_from({"failures": list(words)}).failures == words
