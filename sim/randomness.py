"""Random numbers addressed by (seed, stream, frame): no draw depends on any other draw."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numpy.random.bit_generator import ISeedSequence


class _Key(ISeedSequence):
    """The key of an address, as the seed of a generator.

    Without one `numpy.random.Philox` asks the system for entropy, key or not: most of its time.
    """

    def __init__(self, key: np.ndarray) -> None:
        self.key = key

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> np.ndarray:
        """The two words of 64 bits that a Philox generator takes for its key."""
        assert n_words == len(self.key)
        return self.key.astype(dtype, copy=False)


def generator(seed: int, stream: str, frame: int = 0) -> np.random.Generator:
    """An independent counter-based generator (Philox) for an address.

    The address is hashed into the key, so adding a stream or changing one parameter moves no other
    draw. Raises ValueError for a negative seed or frame.
    """
    if seed < 0 or frame < 0:
        raise ValueError(f"seed and frame must not be negative, got {seed} and {frame}")
    digest = hashlib.blake2b(f"{seed}/{stream}/{frame}".encode(), digest_size=16).digest()
    key = np.frombuffer(digest, dtype="<u8")
    seed_of_key: Any = _Key(key)  # numpy takes any ISeedSequence, its stubs one kind
    return np.random.Generator(np.random.Philox(seed_of_key))
