"""Standard output and error that outlive their reader, as in `pjpdaf-bench run | head`."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from pjpdaf.printable import for_terminal


class _SurvivingStream:
    """A text stream that discards its output once its reader has gone.

    Its reader: of a pipe, or a terminal that is closed. The work goes on to its end and keeps its
    exit code. Control characters, and characters that the stream's encoding lacks, are escaped.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_terminal = stream.isatty()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        text = for_terminal(text)
        try:
            return self._stream.write(text)
        except UnicodeEncodeError:
            encoding = self._stream.encoding
            return self._stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
        except OSError as fault:
            self._discard_or_raise(fault)
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as fault:
            self._discard_or_raise(fault)

    def _discard_or_raise(self, fault: OSError) -> None:
        hung_up = self._is_terminal and fault.errno == errno.EIO
        if not hung_up and not isinstance(fault, BrokenPipeError):
            raise fault
        discard_output(self._stream)


def discard_output(stream: TextIO) -> None:
    """Point the stream's file descriptor at the null device."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)


@contextmanager
def surviving_readers() -> Iterator[None]:
    """Replace standard output and error by streams that survive a closed pipe."""
    before = sys.stdout, sys.stderr
    # A stream that was closed from the start (>&-) is None, and may stay it.
    sys.stdout, sys.stderr = (s and cast(TextIO, _SurvivingStream(s)) for s in before)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        sys.stdout, sys.stderr = before
