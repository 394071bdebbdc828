"""Trackers that each have a fault, in a module that worker processes can import too."""

import os
import time

from pjpdaf.interfaces import Estimates
from pjpdaf.tracker.filter import PJPDAF


class Faulty:
    """A tracker whose `step` is missing."""

    def __init__(self, cameras):
        self.inner = PJPDAF(cameras)

    def start(self, seen):
        """Start as the inner tracker does."""
        return self.inner.start(seen)

    def estimates(self, state):
        """Give the inner tracker's estimates."""
        return self.inner.estimates(state)

    def predict(self, state, dt_s):
        """Predict as the inner tracker does."""
        return self.inner.predict(state, dt_s)


class Raises(Faulty):
    """Raises in its first step."""

    def step(self, state, seen, dt_s):
        """Raise."""
        raise RuntimeError("no step today")


class Dies(Faulty):
    """Ends its process in its first step."""

    def step(self, state, seen, dt_s):
        """End the process."""
        os._exit(7)


class Hangs(Faulty):
    """Does not return from its first step."""

    def step(self, state, seen, dt_s):
        """Sleep."""
        time.sleep(1000)


class Prints(Faulty):
    """Prints in every step."""

    def step(self, state, seen, dt_s):
        """Print, and step as the inner tracker does."""
        print("a step")
        return self.inner.step(state, seen, dt_s)


class Waits(Faulty):
    """Never gives an estimate."""

    def estimates(self, state):
        """Give none."""
        return Estimates.waiting()

    def step(self, state, seen, dt_s):
        """Give none."""
        return state, Estimates.waiting()
