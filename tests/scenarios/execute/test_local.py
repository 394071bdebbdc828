"""What is imported before workers are forked is what every episode needs: it is most of a start."""

import json
import subprocess
import sys

from scenarios.execute.local import PLAYED_WITH

LOADED = f"import json, sys, {', '.join(PLAYED_WITH)}; print(json.dumps([*sys.modules]))"
# Each a tenth of a second or more, for clips, bare arms, data sets, tables, pages, the command.
HEAVY = {
    *(f"scipy.{name}" for name in ("interpolate", "linalg", "ndimage", "optimize", "sparse")),
    *(f"scipy.{name}" for name in ("spatial", "stats")),
    *("pandas", "pyarrow.compute", "pyarrow.parquet", "jinja2", "rich", "typer", "mujoco"),
}


def test_the_server_of_workers_loads_nothing_heavy_that_few_episodes_need():
    done = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True)
    loaded = {*json.loads(done.stdout)}
    assert {"numpy", "cv2", "sim.sequence", "pjpdaf.tracker.jpda"} <= loaded
    assert not loaded & HEAVY
