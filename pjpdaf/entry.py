"""Where the command, its workers and the pytest plug-in begin: our packages before a user's.

`sim`, `reports` and `scenarios` are common words: a project of somebody's may have packages of
these names in its own folder or on PYTHONPATH. Only this package is named like no other; what is
imported through it finds the packages beside it. Nothing but the standard library is imported here.
"""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

PACKAGES = ("pjpdaf", "sim", "reports", "scenarios")
SWAPPED = PACKAGES[1:]  # the common words
ROOT = str(Path(__file__).resolve().parents[1])
_ENDING = ("SIGTERM", "SIGHUP")


class _OwnPackages:
    """Finds our packages in our own folder, whatever the path for imports is."""

    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if path is None and name in PACKAGES:
            return PathFinder.find_spec(name, [ROOT])
        return None


_FINDER: Any = _OwnPackages()
# OpenCV reads this when it is imported. Its own limit, 2^30, lets a file of 3 MB take 3 GB.
PICTURE_PIXELS_MAX = 1 << 26


def own_packages_first() -> None:
    """From now on, importing our packages finds ours. Those already imported stay."""
    if _FINDER not in sys.meta_path:
        sys.meta_path.insert(0, _FINDER)


@contextmanager
def own_packages() -> Iterator[None]:
    """Inside the block `sim`, `reports` and `scenarios` are ours; afterwards a user's are back.

    For code of ours that is called inside somebody's process, such as a test of theirs.
    """
    theirs = {name: _tree(name) for name in SWAPPED if not _is_ours(sys.modules.get(name))}
    for name, modules in theirs.items():
        _forget(modules)
        sys.modules.update(_aside.get(name, {}))
    is_first = _FINDER not in sys.meta_path
    own_packages_first()
    try:
        yield
    finally:
        if is_first:
            sys.meta_path.remove(_FINDER)
        for name, modules in theirs.items():
            if modules or not _path_leads_to_ours(name):
                _aside[name] = _tree(name)
                _forget(_aside[name])
                sys.modules.update(modules)


_aside: dict[str, dict[str, ModuleType]] = {}  # our modules, while they are not in sys.modules


def _tree(name: str) -> dict[str, ModuleType]:
    """The loaded modules of a package, by their full names."""
    return {n: module for n, module in sys.modules.items() if n.partition(".")[0] == name}


def _forget(modules: Mapping[str, ModuleType]) -> None:
    for name in modules:
        del sys.modules[name]


def _is_ours(package: ModuleType | None) -> bool:
    folders = [str(Path(folder).resolve()) for folder in getattr(package, "__path__", ())]
    return package is not None and folders == [str(Path(ROOT, package.__name__))]


def _path_leads_to_ours(name: str) -> bool:
    spec = PathFinder.find_spec(name)
    folders = [] if spec is None else spec.submodule_search_locations or []
    return str(Path(ROOT, name)) in [str(Path(folder).resolve()) for folder in folders]


def main() -> None:
    """Run the command of `sys.argv`; always raises SystemExit with its exit code."""
    own_packages_first()
    _limit_pictures()
    for name in _ENDING:
        # A signal during the first imports ends as Ctrl-C does: with a line, and tidied up.
        if signal.getsignal(getattr(signal, name)) is signal.SIG_DFL:
            signal.signal(getattr(signal, name), _interrupt)
    try:
        _command_main()
    except KeyboardInterrupt:
        sys.stderr.write("pjpdaf-bench: interrupted\n")
        raise SystemExit(130) from None
    finally:
        # The exit code is settled; a further signal must not replace it by a traceback.
        for name in ("SIGINT", *_ENDING):
            with suppress(ValueError):  # not the main thread
                signal.signal(getattr(signal, name), signal.SIG_IGN)


def _command_main() -> None:
    try:
        command = importlib.import_module("scenarios.cli.main")
    except Exception as fault:
        from pjpdaf.unforeseen import report_unforeseen

        raise SystemExit(report_unforeseen(fault, "--debug" in sys.argv)) from None
    command.main()


def _limit_pictures() -> None:
    os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(PICTURE_PIXELS_MAX))


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def serve_forks(channel: Any) -> None:
    """In the process that workers are forked from: answer a socket (`sim.worker_server`)."""
    own_packages_first()
    _limit_pictures()
    importlib.import_module("sim.worker_server").serve_forks(channel)


def call(module: str, name: str, *arguments: Any) -> Any:
    """Call a function of ours in a process of another program, such as a worker of Dask."""
    own_packages_first()
    _limit_pictures()
    return getattr(importlib.import_module(module), name)(*arguments)


async def call_aside(module: str, name: str, *arguments: Any) -> Any:
    """The same, in a thread: the event loop of the other program goes on."""
    import asyncio

    return await asyncio.to_thread(call, module, name, *arguments)


if __name__ == "__main__":
    main()
