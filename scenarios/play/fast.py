"""An episode without rendering: painted silhouettes instead of pictures, the same tracker."""

from __future__ import annotations

from pjpdaf.detector.blob_detector import BlobDetector
from pjpdaf.detector.detector import SkinDetector
from pjpdaf.errors import BenchError
from pjpdaf.follow import follow
from pjpdaf.interfaces import Detector
from pjpdaf.presets.registry import PRESETS
from pjpdaf.tracker.hypotheses.parameters import HypothesisParameters
from reports.score.records import Episode
from scenarios.play.job import Job, System
from scenarios.play.play import episode_of, make_system, outcome_of
from scenarios.play.recipe import sized
from scenarios.spec.draw import unjudged
from sim.silhouettes import blobs_with_looks, skin_blobs
from sim.silhouettes.blobs_with_looks import BlobsWithLooks
from sim.silhouettes.error_model import BlobErrors, ErrorModel, error_model
from sim.silhouettes.film import film_of
from sim.silhouettes.painter import Painter
from sim.silhouettes.skin_blobs import SkinBlobs
from sim.silhouettes.truths import Truths
from sim.steps import step as count_step


def play_fast(job: Job, redraw: int = 0, errors: ErrorModel | None = None) -> Episode:
    """Play a job with painted silhouettes: same motion, cameras and tracker; the bare episode.

    The draw is not judged (`scenarios.spec.draw.fault_of_draw`); redraw: as in
    `scenarios.spec.draw.concrete`. The detector's stages after segmentation are its own; its noise
    is that of a model (docs/stress_fast.md), errors: of another model. Raises BenchError for a
    detector of other kinds than the presets', for a stored sequence or a table of detections.
    """
    if job.kept is not None or job.detections is not None:
        raise BenchError("fast plays scenarios, not stored sequences or tables of detections")
    performance = sized(unjudged(job.scenario, job.seed, job.overrides, redraw), job.size_px)
    step_px, everything = _painting(job.system)
    film = film_of(performance, step_px, everything)
    detector, tracker = make_system(job.system, film.calibration)
    painter = Painter(film, kept=job.system.lag + 1)
    stand_in = _stand_in(detector, painter, errors or error_model(job.system.detector))
    truths = Truths(film)
    outcomes = []
    for step in follow(film.frames(), stand_in, tracker, job.system.lag):
        truth = truths.of(step.frame.index, painter.paint(step.frame.index))
        outcomes.append(outcome_of(step, truth))
        count_step()
    return episode_of(job, film.rig.cameras, performance.fps, outcomes, redraw)


def _painting(system: System) -> tuple[int, bool]:
    """Reduction of the pictures, and whether clothes and things are painted as well."""
    preset = PRESETS.get(system.detector)
    if preset is None:
        raise BenchError(
            f"detector {system.detector!r}: fast has a stand-in for the detectors of presets only; "
            "play it in full"
        )
    if isinstance(preset.tracker, HypothesisParameters):
        return blobs_with_looks.STEP_PX, True
    return skin_blobs.STEP_PX, False


def _stand_in(detector: Detector, painter: Painter, model: ErrorModel) -> Detector:
    film = painter.film
    views = len(film.outlines)
    width_px, seed = film.rig.left.width_px, film.performance.seed
    errors = BlobErrors(model, film.frame_count, views, width_px, seed)
    if isinstance(detector, SkinDetector):
        return SkinBlobs(film.calibration.cameras, detector.parameters, painter, errors)
    assert isinstance(detector, BlobDetector)
    return BlobsWithLooks(
        film.calibration, detector.base.parameters, detector.adaptation, painter, errors
    )
