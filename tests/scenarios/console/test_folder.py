"""Output folders that appear whole or not at all."""

import pytest

from scenarios.console.folder import written_whole


def test_a_folder_appears_whole_or_not_at_all(tmp_path):
    def fail(part):
        (part / "file").write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), written_whole(tmp_path / "a/new") as part:
        fail(part)
    assert list((tmp_path / "a").iterdir()) == []
    with written_whole(tmp_path / "a") as part:  # an empty folder may be there
        (part / "file").write_text("whole")
    assert [f.name for f in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a/file").read_text() == "whole"
