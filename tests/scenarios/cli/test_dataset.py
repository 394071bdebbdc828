"""The verbs of `dataset`: formats, and options that do not go together."""

import pytest
from commands import assert_one_line, in_this_process

from pjpdaf.errors import BenchError
from scenarios.cli.dataset import parse_formats


def test_formats_are_named_in_any_order_and_chosen_by_the_labels():
    assert parse_formats(None, ("depth", "seg")) == ("coco", "mot")
    assert parse_formats(None, ("depth",)) == ("mot",)
    assert parse_formats("none", ()) == ()
    assert parse_formats("mot, coco", ("seg",)) == ("coco", "mot")
    with pytest.raises(BenchError, match="yolo: no such format; did you mean yolo-seg"):
        parse_formats("yolo", ("seg",))
    with pytest.raises(BenchError, match="made of the label seg"):
        parse_formats("coco", ("depth",))


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (("make", "smoke"), "--out is missing"),
        (("make", "--out", "x", "--frame", "3"), "--frame is for a recipe"),
        (("make", "cross", "--out", "x", "--recipe", "r.json"), "leave out the scenarios"),
        (("verify", "nowhere"), "nowhere"),
        (("export", "nowhere"), "nowhere"),
        (("show", "nowhere"), "nowhere"),
    ],
)
def test_a_fault_is_one_line(words, fragment, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_one_line(in_this_process("dataset", *words), 2, fragment)
    assert list(tmp_path.iterdir()) == []
