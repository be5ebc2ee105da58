import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aeroscene.corpus.shipped.decimals import join_doubles, split_doubles

doubles = st.floats(allow_nan=False, allow_infinity=False)


def bits(values):
    return values.view(np.int64).tolist()


@given(arrays(np.float64, st.integers(0, 20), elements=doubles), st.integers(0, 9))
def test_every_finite_double_comes_back_to_the_last_bit(values, digits):
    assert bits(join_doubles(split_doubles(values, digits), digits)) == bits(values)


@given(arrays(np.int64, 10, elements=st.integers(-(2**40), 2**40)), st.integers(0, 9))
def test_a_rounded_number_is_its_decimal_alone(units, digits):
    values = np.array([round(float(unit) / 10**digits, digits) for unit in units.tolist()])
    found = split_doubles(values, digits)
    assert found.units.tolist() == units.tolist()
    assert not found.steps.any()


def test_sums_of_decimals_are_a_few_steps_off():
    values = np.array([0.1 + 0.2, 27.4 + 4e-15, -0.0, 1 - 1e-16])
    assert np.abs(split_doubles(values, 4).steps).max() <= 2
    assert split_doubles(values, 4).units.tolist() == [3000, 274000, 0, 10000]


def test_numbers_that_have_no_decimal_keep_their_value():
    values = np.array([1e300, -1.7976931348623157e308, 5e-324, 2.0**60])
    assert bits(join_doubles(split_doubles(values, 4), 4)) == bits(values)
