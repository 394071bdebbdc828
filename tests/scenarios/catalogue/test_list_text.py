"""The catalogue as text."""

import pytest

from scenarios.catalogue.list_text import WIDTH, catalogue_lines
from scenarios.spec.names import scenario_names, suite_names


def test_the_list_is_aligned_fits_and_names_everything():
    lines = list(catalogue_lines())
    assert max(map(len, lines)) <= WIDTH == 100
    rows = [line for line in lines if not line.startswith(" ")]
    assert [row.split()[0] for row in rows] == ["name", *scenario_names(), *suite_names()]
    places = [rows[0].index(word) for word in ("group", "frames", "T ", "what")]
    for row in rows[1:]:
        assert all(row[place - 2 : place] == "  " for place in places if len(row) > place), row
    calm, cross = (next(r for r in rows if r.startswith(name)) for name in ("calm_", "cross"))
    assert calm[places[2]] == "T"
    assert cross[places[2]] == " "
    assert calm[places[1] :].startswith("150 x 3 ")
    assert all(line[places[3]] != " " for line in lines)


@pytest.mark.parametrize("width", [60, 80])
def test_a_narrow_terminal_has_the_text_below_the_name(width):
    lines = list(catalogue_lines(width))
    assert max(map(len, lines)) <= width
    names = [line.split()[0] for line in lines if not line.startswith(" ")]
    assert names == ["name", *scenario_names(), *suite_names()]
    words = {word for line in lines for word in line.split()}
    assert words == {word for line in catalogue_lines() for word in line.split()}
