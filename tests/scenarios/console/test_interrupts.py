"""Real processes that get real signals; each step waits for a line of the process."""

import signal
import subprocess
import sys
import threading

import pytest
from commands import ENVIRONMENT, ROOT, pending, wait_until

from scenarios.console.interrupts import (
    SIGNALS,
    Interrupted,
    interrupts,
    unwritten_if_interrupted,
)

PRELUDE = """
import signal, sys, time
from pathlib import Path
from scenarios.console.interrupts import Interrupted, interrupts, unwritten_if_interrupted

def say(text):
    print(text, flush=True)

def wait():
    say("waiting")
    sys.stdin.readline()

"""


class Script:
    """A Python process that says lines, and waits for lines."""

    def __init__(self, body, ignored=()):
        # What is ignored here stays ignored in a new process, as below `nohup`.
        before = {number: signal.signal(number, signal.SIG_IGN) for number in ignored}
        self.process = subprocess.Popen(
            [sys.executable, "-c", PRELUDE + body],
            cwd=ROOT,
            env=ENVIRONMENT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for number, handler in before.items():
            signal.signal(number, handler)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()

    def until_waiting(self):
        assert self.process.stdout.readline() == "waiting\n"

    def send(self, number):
        """Send a signal and wait until it is delivered: its handler then runs before all else."""
        self.process.send_signal(number)
        wait_until(lambda: not pending(self.process.pid), self.process)

    def go_on(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def end(self):
        out, err = self.process.communicate(timeout=120)
        assert self.process.returncode == 0, err
        return out.split()


COUNTED = """
with interrupts() as arrived:
    wait()
    say(arrived.count)
    wait()
    say(arrived.count)
"""


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_is_counted_and_saving_goes_on(number):
    with Script(COUNTED) as script:
        script.until_waiting()
        script.send(number)
        script.go_on()
        assert script.process.stdout.readline() == "1\n"
        script.until_waiting()
        script.send(number)
        script.go_on()
        assert script.end() == ["2"]


RAISED_ONCE = """
with interrupts() as arrived:
    try:
        with arrived.raising():
            wait()
            say("not reached")
    except KeyboardInterrupt:
        wait()
        say("saved")
    try:
        with arrived.raising():
            say("not reached")
    except KeyboardInterrupt:
        say("ended")
"""


@pytest.mark.parametrize("number", SIGNALS)
def test_work_ends_at_the_first_signal_and_the_second_does_not_end_the_saving(number):
    with Script(RAISED_ONCE) as script:
        script.until_waiting()
        script.send(number)
        script.until_waiting()
        script.send(signal.SIGTERM)
        script.go_on()
        assert script.end() == ["saved", "ended"]


AT_THE_SECOND = """
with interrupts() as arrived:
    try:
        with arrived.raising(at=2):
            wait()
            say("first")
            wait()
            say("not reached")
    except KeyboardInterrupt:
        say("second")
"""


def test_work_that_ends_by_itself_is_ended_by_a_second_signal():
    with Script(AT_THE_SECOND) as script:
        script.until_waiting()
        script.send(signal.SIGINT)
        script.go_on()
        assert script.process.stdout.readline() == "first\n"
        script.until_waiting()
        script.send(signal.SIGHUP)
        assert script.end() == ["second"]


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_that_the_shell_ignores_stays_ignored(number):
    with Script(COUNTED, ignored=(number,)) as script:
        script.until_waiting()
        script.send(number)
        script.go_on()
        assert script.process.stdout.readline() == "0\n"
        script.until_waiting()
        script.go_on()
        assert script.end() == ["0"]


UNWRITTEN = """
try:
    with unwritten_if_interrupted(Path("film.mp4")):
        wait()
        say("not reached")
except Interrupted as fault:
    say(f"{fault.exit_code}: {fault}")
say(signal.getsignal(signal.SIGTERM) is signal.SIG_DFL)
"""


@pytest.mark.parametrize("number", SIGNALS)
def test_what_is_not_written_is_named(number):
    with Script(UNWRITTEN) as script:
        script.until_waiting()
        script.send(number)
        said = " ".join(script.end())
    assert said == "130: interrupted: film.mp4 is not written True"


def test_the_handlers_before_it_are_restored():
    before = {number: signal.getsignal(number) for number in SIGNALS}
    with interrupts():
        assert all(signal.getsignal(number) != before[number] for number in SIGNALS)
    assert {number: signal.getsignal(number) for number in SIGNALS} == before
    with pytest.raises(ValueError, match="of the block"), interrupts():
        raise ValueError("of the block")
    assert {number: signal.getsignal(number) for number in SIGNALS} == before


def test_blocks_inside_each_other_leave_the_outer_one_in_force(tmp_path):
    with interrupts() as outer:
        with pytest.raises(Interrupted), unwritten_if_interrupted(tmp_path):
            signal.raise_signal(signal.SIGTERM)
        assert not outer.arrived
        signal.raise_signal(signal.SIGTERM)
        assert outer.count == 1


def test_another_thread_than_the_main_one_handles_nothing():
    arrived = []

    def work():
        with interrupts() as stop:
            arrived.append(stop.arrived)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert arrived == [False]
