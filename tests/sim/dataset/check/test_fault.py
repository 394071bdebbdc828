"""The line of a fault."""

from sim.dataset.check.fault import Fault


def test_faults_are_one_printable_line():
    text = str(Fault("a\x1b[31m\nb", "what\x07"))
    assert text.isprintable()
