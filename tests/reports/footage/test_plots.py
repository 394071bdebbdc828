"""Plots of tracks: gaps where there is no estimate, bars as long as a status."""

from reports.footage.plots import paths_figure, time_figure

WAITING, TRACKED, LOST = (("waiting",) * 3, ("tracked",) * 3, ("lost", "tracked", "tracked"))


def test_a_path_has_a_gap_without_an_estimate(record_of):
    samples = record_of([TRACKED, WAITING, TRACKED]).samples
    head = paths_figure(samples)["data"][0]
    assert (head["x"], head["z"]) == ([0.0, None, 0.0], [-0.3, None, -0.3])
    assert head["text"][2] == "frame 2, 1.00 s, tracked"


def test_bars_last_from_sample_to_sample(record_of):
    record = record_of([TRACKED, TRACKED, LOST, LOST], missing=(1,))
    figure = time_figure(record.samples, record.missing_frames)
    bars = {trace["name"]: trace["x"] for trace in figure["data"] if trace["yaxis"] == "y4"}
    assert bars["head tracked"] == [0.0, 1.0, None]
    assert bars["head lost"] == [1.0, 2.0, None]
    assert bars["left hand tracked"] == [0.0, 2.0, None]
    (mark,) = figure["layout"]["shapes"]
    assert (mark["x0"], mark["x1"]) == (0.25, 0.75)
