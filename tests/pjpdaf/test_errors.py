"""Every BenchError of the code base crosses processes whole: type, line, fields, exit code."""

import importlib
import pickle
import pkgutil

import pytest

import pjpdaf
import reports
import scenarios
import sim
from pjpdaf.errors import BenchError, FileError, InfrastructureError, PlugInFault
from pjpdaf.presets.registry import UnknownPreset
from scenarios.spec.faults import FileFault
from scenarios.spec.names import UnknownName

LINE = "the picture is 3x2 px; give a larger one"
# Classes whose constructor takes more than the line.
ARGUMENTS = {
    FileError: ("left.png", "not a picture"),
    FileFault: ("file.yaml", (14, 13), "events.1.speeed: no such field"),
    UnknownName: ("scenario", "drnk", ("drink", "cross")),
    UnknownPreset: ("theses", ("thesis", "thesis-literal")),
}


def subclasses(kind):
    for child in kind.__subclasses__():
        yield child
        yield from subclasses(child)


def all_kinds():
    for package in (pjpdaf, sim, reports, scenarios):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)
    ours = (k for k in subclasses(BenchError) if k.__module__.split(".")[0] != "tests")
    named = (k for k in ours if k.__module__.startswith(("pjpdaf", "sim", "reports", "scenarios")))
    return sorted({BenchError, *named}, key=lambda kind: kind.__qualname__)


@pytest.mark.parametrize("kind", all_kinds(), ids=lambda kind: kind.__qualname__)
def test_every_error_survives_pickling(kind):
    error = kind(*ARGUMENTS.get(kind, (LINE,)))
    there = pickle.loads(pickle.dumps(error))
    assert type(there) is kind
    assert str(there) == str(error)
    assert there.exit_code == error.exit_code == kind.exit_code
    assert vars(there) == vars(error)


class WithFields(BenchError):
    exit_code = 4

    def __init__(self, file, line):
        self.file, self.line = file, line
        super().__init__(f"{file}:{line}: no such field")


def test_fields_of_its_own_come_along_although_the_constructor_takes_other_arguments():
    there = pickle.loads(pickle.dumps(WithFields("a.yaml", 3)))
    assert type(there) is WithFields
    assert (there.file, there.line, there.exit_code) == ("a.yaml", 3, 4)
    assert str(there) == "a.yaml:3: no such field"


def test_a_type_that_cannot_be_pickled_arrives_as_its_line_and_exit_code():
    class Local(InfrastructureError):
        pass

    there = pickle.loads(pickle.dumps(Local(LINE)))
    assert type(there) is BenchError
    assert (str(there), there.exit_code) == (LINE, 5)


def test_a_field_that_cannot_be_pickled_costs_the_type_only():
    error = WithFields("a.yaml", 3)
    error.reader = lambda: None
    there = pickle.loads(pickle.dumps(error))
    assert type(there) is BenchError
    assert (str(there), there.exit_code) == ("a.yaml:3: no such field", 4)


def test_a_type_unknown_at_the_other_end_arrives_as_its_line_and_exit_code(monkeypatch):
    sent = pickle.dumps(WithFields("a.yaml", 3))
    monkeypatch.delitem(globals(), "WithFields")
    there = pickle.loads(sent)
    assert type(there) is BenchError
    assert (str(there), there.exit_code) == ("a.yaml:3: no such field", 4)


def test_reworded_keeps_type_fields_and_exit_code():
    error = WithFields("a.yaml", 3).reworded("cross: no such field")
    assert (str(error), error.file, error.exit_code) == ("cross: no such field", "a.yaml", 4)
    assert pickle.loads(pickle.dumps(error)).file == "a.yaml"


def test_a_plug_ins_fault_survives_pickling():
    there = pickle.loads(pickle.dumps(PlugInFault("tracker 'a:b': step: raises ValueError")))
    assert type(there) is PlugInFault
    assert str(there) == "tracker 'a:b': step: raises ValueError"
