"""Writes the file of a recording, block by block."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any, BinaryIO

import pyarrow as pa

from sim.camera.stereo_sensor import Light
from sim.recording.footer import Footer
from sim.recording.pictures import LEVEL, PictureEncoder
from sim.recording.recording import MAGIC, TAIL
from sim.recording.truths import FrameFacts, facts_to_bytes
from sim.scene.world import CAMERAS
from sim.sequence import Simulation


class RecordingWriter:
    """Writes a recording: the light of the background if there is any, every frame, the footer.

    A disk that refuses ends the recording, not the caller: `failed` is then true.
    """

    def __init__(self, file: BinaryIO) -> None:
        self.failed = False
        self._file = file
        self._digest = hashlib.sha256()
        self._encoders = [PictureEncoder() for _ in CAMERAS]
        self._block_sizes: list[int] = []
        self._facts: list[FrameFacts] = []
        self._write(MAGIC)

    def add_light(self, light: Light) -> None:
        """Write the light of both views."""
        for picture, encoder in zip(light, self._encoders, strict=True):
            self._write_block(encoder.encode(picture))

    def add_frame(self, light: Light, facts: FrameFacts) -> None:
        """Write a frame."""
        self.add_light(light)
        self._facts.append(facts)

    def finish(self, simulation: Simulation, key: Mapping[str, Any]) -> None:
        """Write truth and footer; the file is whole then. key: what decided the pictures."""
        packed = pa.Codec("zstd", LEVEL).compress(facts_to_bytes(self._facts), asbytes=True)
        self._write_block(packed)
        performance = simulation.performance
        footer = Footer(
            key=key,
            renderer=simulation.renderer,
            fps=simulation.fps,
            redrawn=simulation.redrawn,
            seed=performance.seed,
            background_count=performance.background_frames,
            sensor=performance.scene.sensor,
            rig=simulation.rig,
            calibration=simulation.calibration,
            events=tuple(facts.truth.events for facts in self._facts),
            block_sizes=tuple(self._block_sizes),
        ).to_json()
        start = len(MAGIC) + sum(self._block_sizes)
        self._write(footer)
        # The digest covers the two numbers before it as well.
        numbers = TAIL.pack(start, len(footer), bytes(32))[:-32]
        self._write(numbers)
        self._write(self._digest.digest())

    def _write_block(self, data: bytes) -> None:
        self._block_sizes.append(len(data))
        self._write(data)

    def _write(self, data: bytes) -> None:
        self._digest.update(data)
        if not self.failed:
            try:
                self._file.write(data)
            except OSError:
                self.failed = True
