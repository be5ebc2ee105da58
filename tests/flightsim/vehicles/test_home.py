"""Files below a home folder, where there is none."""

import pytest

from flightsim.lidars import lidar_by_name
from flightsim.lidars.definition import LidarError
from flightsim.vehicles.airframe import AirframeError
from flightsim.vehicles.catalogue import airframe_by_name


@pytest.mark.parametrize(
    ("read", "error"), [(airframe_by_name, AirframeError), (lidar_by_name, LidarError)]
)
def test_a_user_without_a_home_folder_gets_one_line(monkeypatch, read, error):
    monkeypatch.delenv("HOME", raising=False)

    def unknown(uid):
        raise KeyError(uid)

    monkeypatch.setattr("pwd.getpwuid", unknown)
    with pytest.raises(error, match=r"'~/mine\.toml'"):
        read("~/mine.toml")
