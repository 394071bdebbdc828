"""Random numbers addressed by (seed, stream, frame): no draw depends on any other draw."""

from __future__ import annotations

import hashlib

import numpy as np


def generator(seed: int, stream: str, frame: int = 0) -> np.random.Generator:
    """An independent counter-based generator (Philox) for an address.

    The address is hashed into the key, so adding a stream or changing one parameter moves no other
    draw. Raises ValueError for a negative seed or frame.
    """
    if seed < 0 or frame < 0:
        raise ValueError(f"seed and frame must not be negative, got {seed} and {frame}")
    digest = hashlib.blake2b(f"{seed}/{stream}/{frame}".encode(), digest_size=16).digest()
    key = np.frombuffer(digest, dtype="<u8")
    return np.random.Generator(np.random.Philox(key=key))
