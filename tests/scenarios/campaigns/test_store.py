"""Results on disk: nothing lost, nothing twice, whatever ends the process."""

import os
import random
import signal
import time

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

from scenarios.campaigns import store
from scenarios.campaigns.store import (
    COLUMNS,
    JOURNAL,
    TABLES,
    TRACKS,
    StoreError,
    open_store,
    read_results,
)
from tests.full_disk import files_end_after


def row(number, **more):
    return {
        "trial_id": f"7/iris/{number}",
        "scene": "7",
        "vehicle": "iris",
        "trial": number,
        "success": number % 2 == 0,
        "contacts": [{"what": "the ground", "time_s": 1.5}],
        "start": (1.0, 2.0, 0.5),
        **more,
    }


def ids(folder):
    return read_results(folder)["trial_id"].to_pylist()


def test_rows_are_there_at_once_and_become_tables(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "ROWS_A_TABLE", 3)
    with open_store(tmp_path) as results:
        for number in range(7):
            results.add(row(number))
            assert ids(tmp_path) == [f"7/iris/{n}" for n in range(number + 1)]
        assert len(list((tmp_path / TABLES).iterdir())) == 2
    assert len(list((tmp_path / TABLES).iterdir())) == 3
    assert (tmp_path / JOURNAL).read_bytes() == b""
    table = read_results(tmp_path)
    assert table["start"].to_pylist()[0] == [1.0, 2.0, 0.5]
    assert table["contacts"].to_pylist()[0] == '[{"what": "the ground", "time_s": 1.5}]'
    assert table["success"].to_pylist()[:2] == [True, False]


def test_a_journal_that_was_cut_short_loses_its_last_line_alone(tmp_path):
    with open_store(tmp_path) as results:
        pass
    whole = b"".join(
        line + b"\n" for line in (b'{"trial_id": "a"}', b'{"trial_id": "b"}', b'{"trial_id": "a"}')
    )
    (tmp_path / JOURNAL).write_bytes(whole + b'{"trial_id": "c')
    assert ids(tmp_path) == ["a", "b"]
    with open_store(tmp_path) as results:
        assert results.done == {"a", "b"}
        results.add(row(1))
    assert ids(tmp_path) == ["a", "b", "7/iris/1"]


def test_a_full_disk_loses_no_row_that_was_kept(tmp_path):
    kept = []

    def fill():
        with open_store(tmp_path) as results, files_end_after(3000):
            for number in range(1000):
                results.add(row(number))
                kept.append(f"7/iris/{number}")

    with pytest.raises(OSError, match="too large"):
        fill()
    assert 5 < len(kept) < 1000
    assert ids(tmp_path) == kept
    with open_store(tmp_path) as results:
        results.add(row(len(kept)))
    assert ids(tmp_path) == [*kept, f"7/iris/{len(kept)}"]


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_killed_at_twenty_moments_it_has_every_row_once(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "ROWS_A_TABLE", 7)
    wanted = [f"7/iris/{n}" for n in range(4000)]
    draw, n_kills, n_before = random.Random(0), 0, 0

    def present():
        return (tmp_path / JOURNAL).stat().st_size, len(list((tmp_path / TABLES).iterdir()))

    while n_kills < 20:
        was_present = present() if n_kills else None
        told, tell = os.pipe()
        pid = os.fork()
        if not pid:
            with open_store(tmp_path) as results:
                for number, trial in enumerate(wanted):
                    if trial not in results.done:
                        results.add(row(number))
                        os.write(tell, f"{trial}\n".encode())
            os._exit(0)
        os.close(tell)
        # From its first new row on, else a slow machine would not come to write any.
        while n_kills and present() == was_present:
            time.sleep(0.001)
        time.sleep(draw.uniform(0.0, 0.03))
        os.kill(pid, signal.SIGKILL)
        status = os.waitpid(pid, 0)[1]
        assert os.WIFSIGNALED(status), "it ended before it was killed"
        n_kills += 1
        with os.fdopen(told) as pipe:
            kept = pipe.read().split()
        found = ids(tmp_path) if (tmp_path / JOURNAL).exists() else []
        assert set(kept) <= set(found)
        assert len(found) >= n_before
        n_before = len(found)
    assert n_before > 10
    with open_store(tmp_path) as results:
        for number, trial in enumerate(wanted[: n_before + 30]):
            if trial not in results.done:
                results.add(row(number))
    assert sorted(ids(tmp_path)) == sorted(wanted[: n_before + 30])


def test_opening_rewrites_nothing(tmp_path, monkeypatch):
    """Whoever is killed while it opens a folder must find all rows again."""
    with open_store(tmp_path):
        pass
    written = b'{"trial_id": "a"}\n{"trial_id": "b'
    (tmp_path / JOURNAL).write_bytes(written)
    monkeypatch.setattr(store.Store, "fold", lambda _: None)
    with open_store(tmp_path):
        pass
    assert (tmp_path / JOURNAL).read_bytes() == written + b"\n"


def test_a_row_in_table_and_journal_counts_once(tmp_path):
    """As where the process was killed after the table and before the journal."""
    with open_store(tmp_path) as results:
        results.add(row(1))
        journal = (tmp_path / JOURNAL).read_bytes()
    (tmp_path / JOURNAL).write_bytes(journal)
    assert ids(tmp_path) == ["7/iris/1"]
    with open_store(tmp_path) as results:
        assert results.done == {"7/iris/1"}
    assert ids(tmp_path) == ["7/iris/1"]


def test_a_damaged_table_is_named_and_its_trials_are_to_fly_again(tmp_path, caplog):
    for number in range(2):
        with open_store(tmp_path) as results:
            results.add(row(number))
    path = tmp_path / TABLES / "00000.parquet"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(StoreError, match=r"00000.parquet' is damaged: .*; valid: remove it"):
        read_results(tmp_path)
    with open_store(tmp_path) as results:
        assert results.done == {"7/iris/1"}
    assert "00000.parquet is damaged and set aside" in caplog.text
    assert ids(tmp_path) == ["7/iris/1"]


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"name": ["a", "b", "c"]}, "it has no column 'trial_id'; valid: remove it"),
        ({"trial_id": ["7/iris/0", None]}, "it has rows without 'trial_id'; valid: remove it"),
    ],
)
def test_a_table_of_something_else_is_named_and_its_rows_are_no_trials(tmp_path, columns, says):
    with open_store(tmp_path):
        pass
    (tmp_path / TABLES).mkdir(exist_ok=True)
    pq.write_table(pa.table(columns), tmp_path / TABLES / "00000.parquet")
    with pytest.raises(StoreError, match=f"table .*00000.parquet' is damaged: {says}"):
        read_results(tmp_path)


def test_only_one_process_at_a_time_adds_rows(tmp_path):
    with open_store(tmp_path), pytest.raises(StoreError, match="another campaign is running"):
        open_store(tmp_path).__enter__()


def test_a_folder_without_a_campaign_is_named(tmp_path):
    with pytest.raises(StoreError, match="holds no campaign; valid: a folder of one"):
        read_results(tmp_path)


def test_tracks_are_kept_beside_the_figures_and_read_where_they_are_asked_for(tmp_path):
    way = [[0.25, 1.0, 2.0], [3.0, 4.0, 5.5]]
    with open_store(tmp_path) as results:
        results.add(row(1, flown_enu_m=way))
        results.add(row(2, flown_enu_m=way, planned_enu_m=way))
        assert read_results(tmp_path, TRACKS).to_pylist() == [
            {"planned_enu_m": None, "flown_enu_m": way},
            {"planned_enu_m": way, "flown_enu_m": way},
        ]
        journalled = read_results(tmp_path, TRACKS, where=pc.field("trial") == 2)
    table = read_results(tmp_path, TRACKS, where=pc.field("trial") == 2)
    assert table.to_pylist() == [{"planned_enu_m": way, "flown_enu_m": way}]
    assert journalled == table
    assert read_results(tmp_path).column_names == list(COLUMNS)


def test_a_campaign_goes_on_by_the_ids_alone(tmp_path):
    with open_store(tmp_path) as results:
        results.add(row(1, flown_enu_m=[[0.25, 1.0, 2.0]]))
    path = tmp_path / TABLES / "00000.parquet"
    chunks = pq.read_metadata(path).row_group(0)
    places = {chunks.column(n).path_in_schema: chunks.column(n) for n in range(chunks.num_columns)}
    begin = places["flown_enu_m.list.element.list.element"].dictionary_page_offset
    data = bytearray(path.read_bytes())
    data[begin : begin + 8] = b"\xff" * 8
    path.write_bytes(data)
    with open_store(tmp_path) as results:
        assert results.done == {"7/iris/1"}
    assert ids(tmp_path) == ["7/iris/1"]
    with pytest.raises(StoreError, match=r"00000.parquet' is damaged"):
        read_results(tmp_path, TRACKS)


def test_columns_that_a_table_is_older_than_are_null(tmp_path):
    with open_store(tmp_path) as results:
        results.add(row(1, energy_j=3.0))
    path = tmp_path / TABLES / "00000.parquet"
    pq.write_table(pq.read_table(path).drop_columns(["energy_j", *TRACKS]), path)
    columns = ["trial_id", "energy_j", "flown_enu_m"]
    assert read_results(tmp_path, columns).to_pylist() == [
        {"trial_id": "7/iris/1", "energy_j": None, "flown_enu_m": None}
    ]
    assert not len(read_results(tmp_path, columns, where=pc.field("energy_j").is_valid()))
