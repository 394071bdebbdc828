"""The verb `score`: anyone's tracks on a data set, scored and saved as a run is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera
from pjpdaf.errors import BenchError
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.targets import TARGETS
from reports.page.page import write_page
from reports.pictures.overlay import overlay_jpeg
from reports.run.load import load
from reports.run.rows import EpisodeRows, rows_of
from reports.run.save import RunInfo, check_free, save
from reports.score.records import Episode, FrameOutcome, OverlayPicture
from reports.summary.tables import rich_table, summarise
from reports.summary.text import count
from scenarios.console.folder import default_folder
from scenarios.console.interrupts import interrupts, unwritten_if_interrupted
from scenarios.console.progress import progress_bar
from scenarios.play.from_dataset import (
    check_once,
    job_of_sequence,
    open_with_sequences,
    renderer_of,
)
from scenarios.play.job import digest_of
from scenarios.play.pictures import PictureChooser
from scenarios.run.save_run import scenario_record
from scenarios.spec.draw import concrete
from scenarios.tracks.files import LOST, Tracks, read_tracks
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence

FRAMES = ("world", "left")
FAR_M = 50.0  # a median distance from the cameras that is no metres
NOTABLE_M = 0.1  # a median error that may come of the wrong --frame


@dataclass(frozen=True)
class ScoreRequest:
    """What the command line asked for; frame: of `FRAMES`, what the positions are in."""

    dataset: Path
    tracks: Path
    out: Path | None = None
    frame: str = "world"
    argv: tuple[str, ...] = ()


@dataclass(frozen=True)
class Facts:
    """What results call a sequence.

    entry: as in run.json (`scenarios.run.save_run.scenario_record`); note: what its user should
    know.
    """

    label: str
    group: str
    seed: int
    digest: str
    values: Mapping[str, float | str] = field(default_factory=dict)
    entry: Mapping[str, Any] = field(default_factory=dict)
    note: str = ""


def score_tracks(request: ScoreRequest) -> None:
    """Read, score, save, print. Raises BenchError, Interrupted after a signal before saving."""
    if request.frame not in FRAMES:
        raise BenchError(f"--frame must be {' or '.join(FRAMES)}, got {request.frame[:40]!r}")
    dataset = open_with_sequences(request.dataset)
    # What a sequence has read stays with it: each use has a copy, and memory does not grow.
    facts = {one.name: facts_of(replace(one)) for one in dataset.sequences}
    counts = {one.name: replace(one).frame_count for one in dataset.sequences}
    check_once(dataset, ((one.label, one.seed) for one in facts.values()))
    stem = request.tracks.absolute().stem
    folder = request.out or default_folder((f"{request.dataset.absolute().name}-{stem}",))
    check_free(folder)
    found = read_tracks(request.tracks, counts)
    notes = sorted({one.note for one in facts.values() if one.note})
    rows = []
    pictured = {one.label: one.seed for one in sorted(facts.values(), key=lambda f: -f.seed)}
    with interrupts():  # while the run is saved, signals are only counted
        with (
            unwritten_if_interrupted(folder),
            progress_bar(Console(stderr=True)) as progress,
        ):
            task = progress.add_task("scoring", total=len(dataset.sequences))
            for sequence in dataset.sequences:
                mine = facts[sequence.name]
                tracks = found.get(sequence.name)
                pictures = pictured[mine.label] == mine.seed
                rows.append(
                    _scored(
                        replace(sequence), mine, tracks, request.frame, notes, pictures=pictures
                    )
                )
                progress.update(task, advance=1)
        saved = load(save(folder, rows, _info(request, dataset, folder, facts)))
        page = write_page([saved], folder / "report.html")
    out = Console()
    out.print(rich_table(summarise(saved)))
    frames = sum(row.frame_count for row in rows)
    said = [f"{count(len(rows), 'sequence')}, {count(frames, 'stereo frame')} scored"]
    for line in (*said, *(f"note: {note}" for note in notes), f"report: {page}"):
        out.print(line, highlight=False, markup=False, soft_wrap=True)


def facts_of(sequence: StoredSequence) -> Facts:
    """Of its recipe, as in a run; of the manifest alone where this version cannot resolve it.

    Raises BenchError where the manifest's entry is incomplete.
    """
    try:
        job = job_of_sequence(sequence)
    except BenchError as fault:
        # Scores need no scenario: an older data set keeps its worth.
        return replace(_of_manifest(sequence), note=f"{fault} Its drawn values are left out.")
    values = {
        name: value if isinstance(value, int | float) else str(value)
        for name, value in concrete(job.scenario, job.seed, job.overrides, sequence.redrawn).items()
    }
    group = job.scenario.group
    return Facts(job.name, group, job.seed, digest_of(job), values, scenario_record(job))


def _of_manifest(sequence: StoredSequence) -> Facts:
    entry = sequence.entry
    texts = {name: entry.get(name) for name in ("label", "group", "digest", "scenario")}
    wrong = [name for name, text in texts.items() if not isinstance(text, str) or len(text) > 200]
    seed = entry.get("seed")
    if wrong or isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise BenchError(
            f"{sequence.folder.parent / 'manifest.json'}: {sequence.name}: must have a "
            f"{wrong[0] if wrong else 'seed'}."
        )
    return Facts(
        str(texts["label"]),
        str(texts["group"]),
        seed,
        str(texts["digest"]),
        entry={"scenario": texts["scenario"]},
    )


def _scored(
    sequence: StoredSequence,
    facts: Facts,
    tracks: Tracks | None,
    frame: str,
    notes: list[str],
    *,
    pictures: bool,
) -> EpisodeRows:
    """One sequence; what its user should know is added to the notes."""
    if tracks is None:
        notes.append(f"{sequence.name} ({facts.label} seed {facts.seed}) has no tracks: all lost")
        estimates = [_nothing()] * sequence.frame_count
    else:
        camera = sequence.calibration.left
        estimates = estimates_of(tracks, camera, frame)
        _check_metres(tracks, estimates, camera)
        other = FRAMES[1 - FRAMES.index(frame)]
        if _much_nearer(sequence, estimates, estimates_of(tracks, camera, other)):
            notes.append(f"{tracks.path}: as --frame {other} the tracks would be much nearer")
    return rows_of(episode_of(sequence, facts, estimates, pictures=pictures))


def estimates_of(tracks: Tracks, camera: Camera, frame: str) -> list[Estimates]:
    """Estimates per frame in the data set's world.

    camera: the left one of the calibration, in whose frame the positions are where frame is "left".
    Deviations become a covariance without correlations.
    """
    positions = tracks.positions_m
    covariances = np.full((*positions.shape, 3), np.nan)
    known = np.isfinite(tracks.sd_m).all(axis=-1)
    covariances[known] = tracks.sd_m[known][:, :, None] ** 2 * np.eye(3)
    if frame == "left":
        R = camera.R_cw.T
        positions = (positions - camera.t_cw) @ R.T
        covariances = R @ covariances @ R.T
    unknown = np.full((len(TARGETS), 3), np.nan)
    return [
        Estimates(position, covariance, unknown, status)
        for position, covariance, status in zip(positions, covariances, tracks.status, strict=True)
    ]


def episode_of(
    sequence: StoredSequence, facts: Facts, estimates: list[Estimates], *, pictures: bool
) -> Episode:
    """What is scored: the data set's truth with these estimates, one a frame.

    Without a tracker nothing can be played again: no stage is blamed, no error budget.
    """
    chooser = PictureChooser(sequence.frame_count) if pictures else None
    nothing_seen = (Detections.none(),) * len(sequence.rig.cameras)
    kept = []
    for truth, said in zip(sequence.truths, estimates, strict=True):
        if chooser is not None and chooser.chooses(truth):
            shown = sequence.frame(truth.index)
            jpeg = overlay_jpeg(shown, sequence.rig.cameras, nothing_seen, said, truth)
            kept.append(OverlayPicture(truth.index, jpeg))
    return Episode(
        scenario=facts.label,
        group=facts.group,
        seed=facts.seed,
        fps=sequence.fps,
        cameras=sequence.rig.cameras,
        frames=tuple(
            FrameOutcome(truth, said)
            for truth, said in zip(sequence.truths, estimates, strict=True)
        ),
        digest=facts.digest,
        values=facts.values,
        redrawn=sequence.redrawn,
        pictures=tuple(kept),
    )


def _check_metres(tracks: Tracks, estimates: list[Estimates], camera: Camera) -> None:
    far = np.linalg.norm(_positions(estimates) - camera.centre_w, axis=-1)
    median = float(np.nanmedian(far)) if np.isfinite(far).any() else 0.0
    if median > FAR_M:
        raise BenchError(
            f"{tracks.path}: the positions are {median:.0f} m from the cameras (median); metres "
            "are expected, not mm"
        )


def _much_nearer(sequence: StoredSequence, one: list[Estimates], other: list[Estimates]) -> bool:
    """Whether the other estimates are so much nearer that they are probably what is meant."""
    centres = np.stack([truth.centres_m for truth in sequence.truths])
    errors = [np.linalg.norm(_positions(said) - centres, axis=-1) for said in (one, other)]
    if not np.isfinite(errors[0]).any():
        return False
    now, then = (float(np.nanmedian(error)) for error in errors)
    return now > NOTABLE_M and then < now / 2


def _positions(estimates: list[Estimates]) -> Floats:
    return np.stack([said.positions_m for said in estimates])


def _nothing() -> Estimates:
    waiting = Estimates.waiting(len(TARGETS))
    return Estimates(
        waiting.positions_m,
        waiting.covariances_m2,
        waiting.velocities_mps,
        (LOST,) * len(TARGETS),
    )


def _info(
    request: ScoreRequest, dataset: Dataset, folder: Path, facts: Mapping[str, Facts]
) -> RunInfo:
    return RunInfo(
        name=folder.name,
        detector="",
        tracker=f"tracks of {request.tracks.absolute().name}",
        parameters={"frame": request.frame},
        renderer=renderer_of(dataset),
        argv=request.argv,
        entries={one.label: one.entry for one in facts.values()},
    )
