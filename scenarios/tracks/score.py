"""The verb `score`: anyone's tracks on a data set, scored and saved as a run is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from pjpdaf.errors import BenchError
from pjpdaf.interfaces import Detections, Estimates
from reports.page.page import write_page
from reports.pictures.overlay import overlay_jpeg
from reports.run.load import load
from reports.run.rows import EpisodeRows, rows_of
from reports.run.save import RunInfo, check_free, save
from reports.score.records import Episode, FrameOutcome, OverlayPicture
from reports.summary.tables import summarise
from reports.summary.terminal import scenario_table, target_table
from reports.summary.text import count
from scenarios.console.folder import default_folder
from scenarios.console.interrupts import interrupts, unwritten_if_interrupted
from scenarios.console.lines import print_line
from scenarios.console.progress import progress
from scenarios.console.tables import print_table
from scenarios.play.from_dataset import (
    check_once,
    open_with_sequences,
    renderer_of,
)
from scenarios.play.pictures import PictureChooser
from scenarios.tracks.estimates import (
    FRAMES,
    check_metres,
    estimates_of,
    frame_shift,
    lost_estimates,
    much_nearer,
)
from scenarios.tracks.files import read_tracks
from scenarios.tracks.identity import SequenceIdentity, identity_of
from scenarios.tracks.tracks import Tracks
from sim.dataset.reader import Dataset
from sim.dataset.stored_sequence import StoredSequence


@dataclass(frozen=True)
class ScoreRequest:
    """The options of `score`.

    frame: of `FRAMES`, in which the positions are; by_target: print a row for each target.
    """

    dataset: Path
    tracks: Path
    out: Path | None = None
    frame: str = "world"
    argv: tuple[str, ...] = ()
    by_target: bool = False


def score_tracks(request: ScoreRequest) -> None:
    """Read, score, save, print. Raises BenchError, Interrupted after a signal before saving."""
    if request.frame not in FRAMES:
        raise BenchError(f"--frame must be {' or '.join(FRAMES)}, got {request.frame[:40]!r}")
    dataset = open_with_sequences(request.dataset)
    # A sequence keeps the files that it has read: each use has a copy, and memory does not grow.
    identities = {s.name: identity_of(replace(s)) for s in dataset.sequences}
    frame_counts = {s.name: replace(s).frame_count for s in dataset.sequences}
    check_once(dataset, ((identity.label, identity.seed) for identity in identities.values()))
    stem = request.tracks.absolute().stem
    folder = request.out or default_folder((f"{request.dataset.absolute().name}-{stem}",))
    check_free(folder)
    tracks_by_name = read_tracks(request.tracks, frame_counts)
    notes = sorted({identity.note for identity in identities.values() if identity.note})
    rows = []
    by_seed = sorted(identities.values(), key=lambda identity: -identity.seed)
    pictured = {identity.label: identity.seed for identity in by_seed}  # the first seed of each
    with interrupts():  # while the run is saved, signals are only counted
        with (
            unwritten_if_interrupted(folder),
            progress() as meter,
        ):
            meter.begin("scoring", sum(frame_counts.values()))
            for sequence in dataset.sequences:
                identity = identities[sequence.name]
                episode, remarks = _score_sequence(
                    replace(sequence),
                    identity,
                    tracks_by_name.get(sequence.name),
                    request.frame,
                    pictures=pictured[identity.label] == identity.seed,
                )
                rows.append(episode)
                notes += remarks
                meter.finish(frame_counts[sequence.name])
        saved = load(save(folder, rows, _info(request, dataset, folder, identities)))
        page = write_page([saved], folder / "report.html")
    out = Console()
    table = target_table if request.by_target else scenario_table
    totals = summarise(saved)
    print_table(table(totals), out, wider=table(totals, wide=True))
    frames = sum(row.frame_count for row in rows)
    summary = f"{count(len(rows), 'sequence')}, {count(frames, 'stereo frame')} scored"
    for line in (summary, *(f"note: {note}" for note in notes), f"report: {page}"):
        print_line(line, out)


def _score_sequence(
    sequence: StoredSequence,
    identity: SequenceIdentity,
    tracks: Tracks | None,
    frame: str,
    *,
    pictures: bool,
) -> tuple[EpisodeRows, list[str]]:
    """Score a sequence; returns its rows and notes for its user."""
    notes = []
    if tracks is None:
        name = f"{sequence.name} ({identity.label} seed {identity.seed})"
        notes.append(f"{name} has no tracks: all lost")
        estimates = [lost_estimates()] * sequence.frame_count
    else:
        camera = sequence.calibration.left
        estimates = estimates_of(tracks, camera, frame)
        check_metres(tracks, estimates, camera)
        other = FRAMES[1 - FRAMES.index(frame)]
        if much_nearer(sequence, estimates, estimates_of(tracks, camera, other)):
            notes.append(f"{tracks.path}: as --frame {other} the tracks would be much nearer")
        shift = frame_shift(sequence, estimates)
        if shift is not None:
            notes.append(
                f"{tracks.path}: {sequence.name}: with frame numbers {shift.frames:+d} the tracks "
                f"would be much nearer where something moves ({shift.then_mm:.0f} mm for "
                f"{shift.now_mm:.0f} mm, median): are its frames counted from 0, and is none lost?"
            )
    return rows_of(episode_of(sequence, identity, estimates, pictures=pictures)), notes


def episode_of(
    sequence: StoredSequence,
    identity: SequenceIdentity,
    estimates: list[Estimates],
    *,
    pictures: bool,
) -> Episode:
    """Join the truth of a sequence with the estimates of its frames.

    Without a tracker nothing can be played again: no stage is blamed, no error budget.
    """
    chooser = PictureChooser(sequence.frame_count) if pictures else None
    no_detections = (Detections.none(),) * len(sequence.rig.cameras)
    kept = []
    for truth, estimate in zip(sequence.truths, estimates, strict=True):
        if chooser is not None and chooser.chooses(truth):
            shown = sequence.frame(truth.index)
            jpeg = overlay_jpeg(shown, sequence.rig.cameras, no_detections, estimate, truth)
            kept.append(OverlayPicture(truth.index, jpeg))
    return Episode(
        scenario=identity.label,
        group=identity.group,
        seed=identity.seed,
        fps=sequence.fps,
        cameras=sequence.rig.cameras,
        frames=tuple(
            FrameOutcome(truth, estimate)
            for truth, estimate in zip(sequence.truths, estimates, strict=True)
        ),
        digest=identity.digest,
        values=identity.values,
        redrawn=sequence.redrawn,
        pictures=tuple(kept),
    )


def _info(
    request: ScoreRequest,
    dataset: Dataset,
    folder: Path,
    identities: Mapping[str, SequenceIdentity],
) -> RunInfo:
    return RunInfo(
        name=folder.name,
        detector="",
        tracker=f"tracks of {request.tracks.absolute().name}",
        parameters={"frame": request.frame},
        renderer=renderer_of(dataset),
        argv=request.argv,
        entries={identity.label: identity.entry for identity in identities.values()},
    )
