"""A meter's figures by a clock of the test, and both ways of showing them."""

import io
import time

import pytest
from rich.console import Console

from scenarios.console.progress import Meter, progress
from sim.steps import counted, step


class Clock:
    now_s = 0.0

    def __call__(self):
        return self.now_s


def metered(total=100, finished=0, **options):
    clock = Clock()
    meter = Meter(clock=clock, **options)
    meter.begin("0/4 episodes", total, finished=finished)
    return meter, clock


def test_time_left_is_there_after_the_first_frames():
    meter, clock = metered()
    assert meter.figures() == "0/100 frames"
    clock.now_s = 8.0  # workers start: no part of the pace
    meter.step()
    assert meter.figures() == "1/100 frames"
    clock.now_s = 9.0
    meter.step()
    assert meter.figures() == "2/100 frames, 1 min 38 s left"
    assert meter.plain_line() == ("progress: 0/4 episodes, 2/100 frames, 1 min 38 s left, 9 s gone")


def test_frames_of_finished_and_of_running_parts_are_summed():
    running = [0]
    meter, _ = metered(running=lambda: running[0], finished=40)
    assert meter.done == 40
    running[0] = 7
    assert meter.done == 47
    running[0] = 0
    meter.finish(10, "1/4 episodes")
    assert (meter.done, meter.doing) == (50, "1/4 episodes")
    meter.finish(200)  # a worker that was killed counts its frames twice
    assert meter.figures().startswith("100/100 frames")


def test_a_total_that_grows():
    meter, clock = metered(total=None)
    assert meter.share is None
    meter.expect(10)
    for clock.now_s in (1.0, 2.0):
        meter.step()
        figures = meter.figures()
    assert figures == "2/10 frames, 8 s left"
    meter.expect(5)
    assert meter.figures() == "2/15 frames, 13 s left"


def test_what_was_finished_before_is_no_part_of_the_pace():
    meter, clock = metered(finished=90)
    for clock.now_s in (1.0, 2.0, 3.0):
        meter.step()
        figures = meter.figures()
    assert figures == "93/100 frames, 7 s left"


def test_the_pace_is_of_the_last_two_minutes():
    meter, clock = metered(total=1000)
    for _ in range(100):  # from the cache
        clock.now_s += 0.1
        meter.step()
        meter.figures()
    for _ in range(130):
        clock.now_s += 1.0
        meter.step()
        meter.figures()
    left_s = 1000 - 230
    assert meter.figures() == f"230/1000 frames, {left_s // 60} min {left_s % 60} s left"


def test_a_finished_part_that_is_not_counted_yet_does_not_change_the_pace():
    running = [0]
    meter, clock = metered(total=1000, running=lambda: running[0])
    for _ in range(60):
        clock.now_s += 2.0
        running[0] += 1
        meter.figures()
    running[0] = 0
    clock.now_s += 1.0
    meter.figures()
    meter.finish(60)
    clock.now_s += 1.0
    assert meter.figures() == "60/1000 frames, 31 min 20 s left"  # 2 s a frame


@pytest.mark.parametrize("columns", [40, 60, 80, 120])
def test_the_live_line_is_one_line_and_cuts_the_words_first(columns):
    meter, _ = metered()
    meter.doing = "a-scenario-of-a-long-name seed 1000000, 12/25 episodes"
    meter.step()
    console = Console(file=io.StringIO(), width=columns)
    console.print(meter.live_line(columns))
    (line,) = console.file.getvalue().splitlines()
    assert line.rstrip().endswith("1/100 frames 0 s gone")
    assert len(line) <= columns


def test_a_log_gets_plain_lines_and_a_short_job_none(capsys):
    with progress(plain_s=0.05) as meter:
        meter.begin("tracking", 3)
        for _ in counted(range(2)):
            pass
        time.sleep(0.2)
    lines = capsys.readouterr().err.splitlines()
    assert 1 <= len(lines) <= 4
    assert lines[0].startswith("progress: tracking, 2/3 frames")
    with progress() as meter:
        meter.begin("tracking", 3)
    assert capsys.readouterr().err == ""


def test_a_terminal_gets_a_line_that_leaves_nothing(capsys):
    class Screen(io.StringIO):
        def isatty(self):
            return True

    screen = Screen()
    console = Console(file=screen, force_terminal=True, width=80, legacy_windows=False)
    with progress(console) as meter:
        meter.begin("tracking", 3)
        step()
        time.sleep(0.6)
    assert "1/3 frames" in screen.getvalue()
    assert screen.getvalue().endswith("\x1b[2K")
    assert capsys.readouterr().err == ""


def test_steps_outside_a_meter_count_nowhere():
    step()
