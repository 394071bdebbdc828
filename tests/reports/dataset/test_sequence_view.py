"""The pictures of a sequence: every layer, frame by frame."""

import cv2
import numpy as np

from reports.dataset import label_colours
from reports.dataset.sequence_view import LAYERS, VIEW_PX


def picture(clip, layer, index):
    return cv2.imdecode(np.frombuffer(clip.layers[layer][index], np.uint8), cv2.IMREAD_COLOR)


def test_every_layer_that_was_written_is_there_frame_by_frame(shown):
    assert list(shown[0].layers) == list(LAYERS)
    assert list(shown[1].layers) == ["colour", "depth"]
    for clip in shown:
        assert clip.frames == clip.sequence.frame_count
        for webps in clip.layers.values():
            assert len(webps) == clip.frames
    assert picture(shown[0], "colour", 3).shape == (240, 2 * VIEW_PX, 3)


def test_ids_keep_their_colours(shown):
    sequence = shown[0].sequence
    known = {label_colours.instance_colour(one.id) for one in sequence.instances}
    colours = np.unique(picture(shown[0], "seg", 2).reshape(-1, 3), axis=0)
    assert {tuple(c) for c in colours.tolist()} <= known
    assert len(colours) >= 4
