"""ZIP archives that are small and unpack to much."""

import zipfile

import pytest

from sim.archives import bounded_archive


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for k in range(20):
            archive.writestr(f"{k}", bytes(1 << 20))
    return path


def test_the_limit_is_on_all_entries_together(path):
    with bounded_archive(path, 20 << 20) as archive:
        assert len(archive.read("3")) == 1 << 20
    with pytest.raises(zipfile.BadZipFile, match="is larger than 19 MiB unpacked"):
        bounded_archive(path, 19 << 20)


def test_a_list_of_entries_without_end(path, monkeypatch):
    monkeypatch.setattr("sim.archives.MAX_DIRECTORY_BYTES", 100)
    with pytest.raises(zipfile.BadZipFile, match="has too many entries"):
        bounded_archive(path, 20 << 20)


@pytest.mark.parametrize("content", [b"", b"PK", b"PK\x05\x06", b"x" * 100])
def test_no_archive(path, content):
    path.write_bytes(content)
    with pytest.raises(zipfile.BadZipFile):
        bounded_archive(path, 1)
