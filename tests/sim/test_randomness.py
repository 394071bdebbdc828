"""Addressed random numbers: numpy's Philox by the key of an address, and nothing else."""

import hashlib
import pickle

import numpy as np
import pytest

from sim.randomness import generator

ADDRESSES = [(0, "a", 0), (0, "a", 1), (0, "b", 0), (1, "a", 0), (10, "a", 0), (2**40, "a/0", 7)]


@pytest.mark.parametrize("address", ADDRESSES)
def test_numbers_are_those_of_the_key_of_the_address(address):
    seed, stream, frame = address
    digest = hashlib.blake2b(f"{seed}/{stream}/{frame}".encode(), digest_size=16).digest()
    key = np.frombuffer(digest, "<u8")
    given = np.random.Generator(np.random.Philox(key=key))
    mine = generator(*address)
    assert mine.random(5).tolist() == given.random(5).tolist()
    assert mine.integers(2**31, size=9).tolist() == given.integers(2**31, size=9).tolist()
    again = pickle.loads(pickle.dumps(mine))
    assert again.standard_normal(3).tolist() == given.standard_normal(3).tolist()


def test_no_two_addresses_share_their_numbers():
    assert len({generator(*address).random() for address in ADDRESSES}) == len(ADDRESSES)


@pytest.mark.parametrize("address", [(-1, "a", 0), (0, "a", -1)])
def test_a_negative_address_is_refused(address):
    with pytest.raises(ValueError, match="must not be negative"):
        generator(*address)
