"""Code of users by name: an entry point of a group, or 'module:factory'."""

from __future__ import annotations

import importlib
import sys
import sysconfig
import traceback
from collections.abc import Callable, Collection
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, cast

from pjpdaf.errors import BenchError, did_you_mean
from pjpdaf.printable import printable

_OURS = str(Path(__file__).parents[1])
_LIBRARIES = (sysconfig.get_path("stdlib"), sysconfig.get_path("purelib"), "<")


class PlugInError(BenchError):
    """Code of a user that cannot be loaded or built."""


class NoSuchPlugIn(PlugInError):
    """There is no plug-in of this name."""


def describe_exception(fault: BaseException) -> str:
    """Describe an exception of a user's code in one line: type, text, file and line number."""
    try:
        # Of a BenchError the text as it was raised, before its line breaks were escaped.
        raised = super(BenchError, fault).__str__() if isinstance(fault, BenchError) else str(fault)
        text = printable(" ".join(raised.split()))
    except Exception:  # of their own __str__
        text = ""
    stack = traceback.extract_tb(fault.__traceback__)[1:]  # the first is the caller's `try`
    theirs = [f for f in stack if not f.filename.startswith((_OURS, *_LIBRARIES))]
    # Where all of it is installed, the deepest place is all there is.
    last = (theirs or stack)[-1:]
    place = f" ({Path(last[0].filename).name}:{last[0].lineno})" if last else ""
    if isinstance(fault, SyntaxError):  # its text has the place; the stack is Python's own
        place = ""
    return f"{type(fault).__name__}{': ' if text else ''}{text[:200]}{place}"


def allow_plug_ins_from_here(*names: str) -> None:
    """Let a module:factory among `names` lie in the current folder.

    The folder comes last on the path, so that it hides no library.
    """
    here = str(Path.cwd())
    if any(":" in name for name in names) and here not in sys.path:
        sys.path.append(here)


def entry_point_names(group: str) -> tuple[str, ...]:
    """Names of the installed entry points of a group, sorted."""
    return tuple(sorted(point.name for point in entry_points(group=group)))


def find_factory(
    kind: str, group: str, name: str, ours: Collection[str] = (), takes: str = ""
) -> Callable[..., Any]:
    """Load the factory of a plug-in by its name.

    kind: what it is, for messages; ours: names that may have been meant, beside the entry points;
    takes: its arguments, for messages. Raises NoSuchPlugIn for a name that is not there,
    PlugInError for code that cannot be loaded.
    """
    factory = _entry_point(kind, group, name) or _attribute(kind, group, name, ours)
    if not callable(factory):
        raise PlugInError(f"The {kind} {name!r} is no function{takes}.")
    return cast(Callable[..., Any], factory)


def call_plug_in(cannot: str, function: Callable[..., Any], *arguments: object) -> Any:
    """Call code of a user. Raises its BenchError, or PlugInError: `cannot`, then what it raised."""
    try:
        return function(*arguments)
    except BenchError:
        raise
    except (Exception, SystemExit) as fault:
        raise PlugInError(f"{cannot} {describe_exception(fault)}.") from fault


def _entry_point(kind: str, group: str, name: str) -> object | None:
    """Load an installed entry point; None where there is no such entry point."""
    for point in entry_points(group=group):
        if point.name == name:
            try:
                loaded: object = point.load()
            except (Exception, SystemExit) as fault:
                cause = describe_exception(fault)
                raise PlugInError(f"The {kind} {name!r} cannot be loaded: {cause}.") from fault
            return loaded
    return None


def _attribute(kind: str, group: str, name: str, ours: Collection[str]) -> object:
    """Import the object that 'module:factory' names."""
    module_name, colon, attribute = name.partition(":")
    if not colon:
        known = sorted({*ours, *entry_point_names(group)})
        raise NoSuchPlugIn(
            f"No {kind} {name!r}.{did_you_mean(name, known)} "
            "A factory of your own is written module:factory."
        )
    cannot = f"The {kind} {name!r} cannot be imported"
    try:
        module = importlib.import_module(module_name)
    except (ImportError, ValueError) as fault:
        gone = isinstance(fault, ModuleNotFoundError) and fault.name == module_name
        raise (NoSuchPlugIn if gone else PlugInError)(f"{cannot}: {fault}.") from fault
    except (Exception, SystemExit) as fault:  # from code that runs when their module is imported
        raise PlugInError(f"{cannot}: {describe_exception(fault)}.") from fault
    if not hasattr(module, attribute):
        public = [w for w, value in vars(module).items() if callable(value) and w[0] != "_"]
        raise NoSuchPlugIn(f"No {attribute!r} in {module_name!r}.{did_you_mean(attribute, public)}")
    return getattr(module, attribute)
