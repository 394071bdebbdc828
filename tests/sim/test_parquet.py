"""Parquet files that are small and unpack to much."""

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sim.parquet import TooLarge, read_bounded


@pytest.fixture
def file(tmp_path):
    def write(**columns):
        path = tmp_path / "table.parquet"
        pq.write_table(pa.table(columns), path, compression="zstd")
        assert path.stat().st_size < 100_000
        return path

    return write


def test_the_columns_come_as_they_were(file):
    columns = {"name": pa.array(["a", None, "a"]), "x": pa.array([1.0, 2.0, None])}
    columns["many"] = pa.array([[1], [], [2, 3]])
    path = file(**columns)
    assert read_bounded(path).equals(pa.table(columns))
    assert read_bounded(path, ["x"]).equals(pa.table({"x": columns["x"]}))


def test_too_many_cells(file, monkeypatch):
    monkeypatch.setattr("sim.parquet.MAX_CELLS", 10_000)
    with pytest.raises(TooLarge, match="has more than 10000 cells"):
        read_bounded(file(x=pa.repeat(0.0, 20_000)))
    with pytest.raises(TooLarge, match="has more than 10000 cells"):
        read_bounded(file(x=pa.array([[0] * 20_000])))


def test_too_much_text(file, monkeypatch):
    monkeypatch.setattr("sim.parquet.MAX_TEXT_BYTES", 1 << 20)
    with pytest.raises(TooLarge, match="has more than 1 MiB in column 'x'"):
        read_bounded(file(x=pa.repeat("x" * 10_000, 1000)))
    monkeypatch.setattr("sim.parquet.MAX_PAGE_BYTES", 1 << 20)
    with pytest.raises(TooLarge, match="is larger than 1 MiB unpacked"):
        read_bounded(file(x=pa.array(["x" * 2_000_000])))
