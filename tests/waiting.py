"""Waiting for a page, where its own rules forbid what Playwright's wait_for_function does."""

import time


def until(view, function, argument=None, limit_s=120.0):
    """Until a JavaScript function of the argument holds; AssertionError after limit_s."""
    end = time.monotonic() + limit_s
    while not view.evaluate(function, argument):
        assert time.monotonic() < end, function
        time.sleep(0.05)
