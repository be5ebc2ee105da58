"""The log of a plant: the columns of the rotors that there are, and nothing of the others."""

import numpy as np

from flightsim.plant.record import HISTORY_DTYPE, history_dtype, with_rotors, without_gaps


def test_rows_show_the_rotors_that_there_are():
    wide = np.zeros(3, HISTORY_DTYPE)
    shown = with_rotors(wide, 6)
    wide["rotor_speed_radps"] = np.arange(36.0).reshape(3, 12)
    wide["quat_est_wxyz"][:, 2] = 0.5
    np.testing.assert_array_equal(shown["rotor_speed_radps"], wide["rotor_speed_radps"][:, :6])
    np.testing.assert_array_equal(shown["quat_est_wxyz"], wide["quat_est_wxyz"])
    assert np.shares_memory(shown, wide)


def test_what_lies_between_the_columns_is_no_part_of_a_copy():
    copies = []
    for unused_radps in (0.0, 7.0):
        wide = np.zeros(2, HISTORY_DTYPE)
        wide["rotor_command_radps"][:, :4] = 800.0
        wide["rotor_command_radps"][:, 4:] = unused_radps
        copies.append(without_gaps(with_rotors(wide, 4)))
    assert copies[0].dtype == history_dtype(4)
    assert copies[0].tobytes() == copies[1].tobytes()
    assert len(copies[0].tobytes()) == 2 * history_dtype(4).itemsize
