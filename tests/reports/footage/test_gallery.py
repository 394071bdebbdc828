"""The pictures of footage: evenly spaced, and the first of each event."""

from reports.footage.gallery import MAX_EVEN_PICTURES, MAX_EVENT_PICTURES

WAITING, TRACKED, LOST = (("waiting",) * 3, ("tracked",) * 3, ("lost", "tracked", "tracked"))


def test_the_first_frame_of_each_event_is_shown_once(record_of):
    record = record_of([WAITING] * 3 + [TRACKED] * 4 + [LOST] * 2 + [TRACKED] + [LOST])
    captions = [caption for caption, _ in record.pictures]
    assert "frame 3, 1.5 s: tracking begins" in captions
    assert "frame 7, 3.5 s: head lost" in captions
    assert sum("lost" in caption for caption in captions) == 1
    assert dict(record.pictures)["frame 7, 3.5 s: head lost"] == b"jpeg 7"


def test_any_length_has_a_few_evenly_spaced_pictures(record_of):
    record = record_of([TRACKED] * 500)
    assert len(record.pictures) <= MAX_EVEN_PICTURES + MAX_EVENT_PICTURES
    frames = [int(jpeg.split()[1]) for _, jpeg in record.pictures]
    assert frames[:3] == [0, frames[1], 2 * frames[1]]
    assert frames[-1] > 400
