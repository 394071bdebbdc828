"""Pictures come back as they were, whatever changes from one to the next."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from sim.recording.pictures import PictureDecoder, PictureEncoder

PICTURES = st.lists(arrays.arrays(np.uint8, (5, 7, 3)), min_size=1, max_size=4)


@given(PICTURES)
def test_pictures_come_back_in_order(pictures):
    encoder, decoder = PictureEncoder(), PictureDecoder(5, 7)
    blocks = [encoder.encode(picture) for picture in pictures]
    for picture, block in zip(pictures, blocks, strict=True):
        np.testing.assert_array_equal(decoder.decode(block), picture)


def test_what_stands_still_costs_nothing():
    picture = np.random.default_rng(0).integers(0, 256, (48, 64, 3), np.uint8)
    encoder = PictureEncoder()
    assert len(encoder.encode(picture)) > 9000
    assert len(encoder.encode(picture)) < 100


def test_the_caller_may_write_into_a_picture_that_it_gave():
    picture = np.zeros((5, 7, 3), np.uint8)
    encoder, decoder = PictureEncoder(), PictureDecoder(5, 7)
    first = encoder.encode(picture)
    picture[:] = 9
    np.testing.assert_array_equal(decoder.decode(first), 0)
    np.testing.assert_array_equal(decoder.decode(encoder.encode(picture)), 9)


@pytest.mark.parametrize("size", [(5, 8), (5, 6), (500, 700)])
def test_a_block_of_another_size_is_refused(size):
    block = PictureEncoder().encode(np.zeros((5, 7, 3), np.uint8))
    with pytest.raises(ValueError, match="picture"):
        PictureDecoder(*size).decode(block)
    with pytest.raises(ValueError, match="picture"):
        PictureDecoder(5, 7).decode(b"no zstd")
