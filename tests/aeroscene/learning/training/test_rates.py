import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeroscene.learning.training.rates import rate_factor

SHARES = st.floats(0, 1)


def factor(schedule, share, step=10**6, warmup=100, cooldown=0.4):
    return rate_factor(schedule, share, step, warmup_steps=warmup, cooldown_share=cooldown)


@given(schedule=st.sampled_from(["cosine", "cooldown", "constant"]), share=SHARES)
def test_factor_is_between_nothing_and_the_whole(schedule, share):
    assert 0.0 <= factor(schedule, share) <= 1.0


@given(first=SHARES, second=SHARES, schedule=st.sampled_from(["cosine", "cooldown"]))
def test_rate_never_rises_after_the_warm_up(first, second, schedule):
    low, high = sorted((first, second))
    assert factor(schedule, low) >= factor(schedule, high) - 1e-12


def test_cosine_is_the_papers():
    assert factor("cosine", 0.0) == pytest.approx(1.0)
    assert factor("cosine", 0.5) == pytest.approx(0.5)
    assert factor("cosine", 1.0) == pytest.approx(0.0)


def test_cooldown_holds_then_falls_in_a_line():
    assert factor("cooldown", 0.6) == pytest.approx(1.0)
    assert factor("cooldown", 0.8) == pytest.approx(0.5)
    assert factor("cooldown", 1.0) == 0.0
    assert factor("cooldown", 1.0, cooldown=0.0) == 0.0


def test_constant_stays():
    assert factor("constant", 1.0) == 1.0


@given(schedule=st.sampled_from(["cosine", "cooldown", "constant"]))
def test_warm_up_grows_step_by_step(schedule):
    rates = [factor(schedule, 0.0, step) for step in range(120)]
    assert rates[0] == pytest.approx(0.01)
    assert rates[49] == pytest.approx(0.5)
    assert rates[99] == rates[119] == pytest.approx(1.0)
