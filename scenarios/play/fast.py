"""An episode without rendering: painted silhouettes instead of pictures, the same tracker."""

from __future__ import annotations

from pjpdaf.detector.detector import SkinDetector
from pjpdaf.errors import BenchError
from pjpdaf.follow import follow
from pjpdaf.interfaces import Detector
from reports.score.records import Episode, FrameOutcome
from scenarios.play.job import Job, System, digest_of
from scenarios.play.play import make_system
from scenarios.play.recipe import sized
from scenarios.spec.draw import concrete, unjudged
from sim.silhouettes.error_model import BlobErrors, ErrorModel
from sim.silhouettes.film import film_of
from sim.silhouettes.painter import Painter
from sim.silhouettes.skin_blobs import STEP_PX, SkinBlobs
from sim.silhouettes.truths import Truths


def play_fast(job: Job, redraw: int = 0) -> Episode:
    """Play a job with painted silhouettes: same motion, cameras and tracker; the bare episode.

    The draw is not judged (`scenarios.spec.draw.fault_of_draw`); redraw: as in
    `scenarios.spec.draw.concrete`. The detector's stages after segmentation are its own, its
    errors are those of a model (docs/stress_fast.md). Raises BenchError for a detector of
    other kinds than the presets', for a stored sequence or a table of detections.
    """
    if job.kept is not None or job.detections is not None:
        raise BenchError("fast plays scenarios, not stored sequences or tables of detections")
    performance = sized(unjudged(job.scenario, job.seed, job.overrides, redraw), job.size_px)
    film = film_of(performance, STEP_PX, everything=False)
    detector, tracker = make_system(job.system, film.calibration)
    painter = Painter(film)
    stand_in = _stand_in(job.system, detector, painter)
    truths = Truths(film)
    outcomes = []
    for step in follow(film.frames(), stand_in, tracker):
        truth = truths.of(step.frame.index, painter.paint(step.frame.index))
        stages_s = {"render": step.render_s, "detect": step.detect_s, "track": step.track_s}
        outcomes.append(FrameOutcome(truth, step.estimates, step.detections, stages_s))
    return Episode(
        scenario=job.name,
        group=job.scenario.group,
        seed=job.seed,
        fps=performance.fps,
        cameras=film.rig.cameras,
        frames=tuple(outcomes),
        digest=digest_of(job),
        values=concrete(job.scenario, job.seed, job.overrides, redraw),
        redrawn=redraw,
    )


def _stand_in(system: System, detector: Detector, painter: Painter) -> Detector:
    film = painter.film
    views = len(film.outlines)
    errors = BlobErrors(ErrorModel(), film.frame_count, views, film.performance.seed)
    if isinstance(detector, SkinDetector):
        return SkinBlobs(film.calibration.cameras, detector.parameters, painter, errors)
    raise BenchError(
        f"detector {system.detector!r}: fast has a stand-in for the detectors of presets only; "
        "use full"
    )
