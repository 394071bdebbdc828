"""Makes tests/strategies.py importable as `strategies` in every test."""

import sys
from pathlib import Path

# Last: tests/pjpdaf must not hide the package pjpdaf.
sys.path.append(str(Path(__file__).parent))
