"""The light of a recording's frames, by its number, and pictures that are read when looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import accumulate
from typing import overload

from pjpdaf.arrays import Image
from sim.camera.stereo_sensor import Light
from sim.recording.pictures import PictureDecoder
from sim.scene.world import CAMERAS

Pictures = tuple[Image | None, ...]  # of each view


class LightReader:
    """Reads the light of both views, by its number in the recording.

    read_at: gives the bytes at a place of the file; start: where the first block begins; sizes:
    bytes of each block, those of both views in turn. Each block is the difference to the one
    before, so that those between the last light and the next are read as well.
    """

    def __init__(
        self,
        read_at: Callable[[int, int], bytes],
        start: int,
        sizes: Sequence[int],
        height_px: int,
        width_px: int,
    ) -> None:
        self._read_at, self._size = read_at, (height_px, width_px)
        self._blocks = list(zip(accumulate(sizes, initial=start), sizes, strict=False))
        self._lights = self._from_start()
        self._last: tuple[int, Light] | None = None

    def __call__(self, number: int) -> Light:
        """The light of this number. Raises ValueError for a block that is none."""
        if self._last is not None and number < self._last[0]:
            self._lights, self._last = self._from_start(), None
        while self._last is None or self._last[0] < number:
            self._last = next(self._lights)
        return self._last[1]

    def _from_start(self) -> Iterator[tuple[int, Light]]:
        """Yield the number and the light of all, in order."""
        decoders = [PictureDecoder(*self._size) for _ in CAMERAS]
        pairs = zip(self._blocks[::2], self._blocks[1::2], strict=True)
        for number, pair in enumerate(pairs):
            left, right = (
                decoder.decode(self._read_at(*block))
                for decoder, block in zip(decoders, pair, strict=True)
            )
            yield number, (left, right)


class PicturesOnDemand(Sequence[Image | None]):
    """The pictures of a frame, read when one of them is looked at first."""

    def __init__(self, read: Callable[[], Pictures]) -> None:
        self._read = read

    @cached_property
    def _pictures(self) -> Pictures:
        return self._read()

    @overload
    def __getitem__(self, at: int) -> Image | None: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[Image | None]: ...
    def __getitem__(self, at: int | slice) -> Image | Sequence[Image | None] | None:
        return self._pictures[at]

    def __len__(self) -> int:
        return len(self._pictures)
