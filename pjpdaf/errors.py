"""Faults that a user can put right; the command line prints them as one line."""


class BenchError(Exception):
    """A fault of the input: rule, value, choices, remedy, in one line. Exit code 2."""

    exit_code = 2


class InfrastructureError(BenchError):
    """The machine lacks something (OpenGL, disk, a worker that died). Exit code 5."""

    exit_code = 5
