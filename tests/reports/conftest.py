"""Synthetic episodes: known paths, known estimates, no simulator."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np
import pytest

from pjpdaf.camera import Camera, project
from pjpdaf.interfaces import Detections, Estimates
from reports.score.records import Episode, FrameOutcome, OverlayPicture
from sim.truth import Truth, ViewTruth

LEFT_HANDED_TURN = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
NEVER_MERGED = np.zeros((3, 3), dtype=bool)


def make_cameras(distortion: Sequence[float] = ()) -> tuple[Camera, Camera]:
    """Level cameras at x = 1.3 m, z = 1 m, 90 mm apart, that look at the person along -x."""
    K = np.array([[540.0, 0.0, 319.5], [0.0, 540.0, 239.5], [0.0, 0.0, 1.0]])
    cameras = []
    # From the cameras the person's left (+y) is on the right of the picture: x_c = y.
    for y in (-0.045, 0.045):
        centre = np.array([1.3, y, 1.0])
        cameras.append(
            Camera(K, LEFT_HANDED_TURN, -LEFT_HANDED_TURN @ centre, 640, 480, np.array(distortion))
        )
    return cameras[0], cameras[1]


def make_paths(frames: int, fps: float, speed_hz: float = 0.12) -> np.ndarray:
    """Head still, hands on ellipses above the table, 0.24 m and more apart, (frames, 3, 3) [m]."""
    t = np.arange(frames) / fps
    phase = 2 * np.pi * speed_hz * t
    head = np.stack([0.05 + 0.004 * np.sin(phase), 0.006 * np.cos(phase), 1.2 + 0 * t], axis=1)
    right = np.stack(
        [0.35 + 0.06 * np.cos(phase), -0.2 + 0.08 * np.sin(phase), 0.85 + 0.05 * np.sin(2 * phase)],
        1,
    )
    left = np.stack(
        [0.35 + 0.05 * np.sin(phase), 0.2 - 0.08 * np.cos(phase), 0.85 + 0.04 * np.cos(phase)], 1
    )
    return np.stack([head, right, left], axis=1)


def make_truth(
    index: int,
    time_s: float,
    centres_m: np.ndarray,
    cameras: Sequence[Camera],
    merged: Sequence[np.ndarray] = (NEVER_MERGED, NEVER_MERGED),
    labels: tuple[str, ...] = (),
) -> Truth:
    """A truth whose visible skin is centred on the projected centres, 15 mm in front of them."""
    views = []
    for camera, pairs in zip(cameras, merged, strict=True):
        pixels = project(camera, centres_m)
        views.append(
            ViewTruth(
                centroids_px=pixels,
                visible_px=np.array([4000, 1500, 1400]),
                amodal_px=np.array([4500, 1500, 1750]),
                boxes_px=np.column_stack([pixels - 25, np.full((3, 2), 50.0)]),
                merged=pairs,
            )
        )
    surfaces = centres_m + np.array([0.015, 0.0, 0.0])
    return Truth(index, time_s, centres_m, np.zeros((3, 3)), surfaces, tuple(views), labels)


def make_episode(
    estimates_m: np.ndarray | None = None,
    *,
    scenario: str = "calm_table",
    group: str = "baseline",
    seed: int = 0,
    fps: float = 3.0,
    frames: int = 30,
    centres_m: np.ndarray | None = None,
    merged: Callable[[int], Sequence[np.ndarray]] | None = None,
    labels: Callable[[int], tuple[str, ...]] | None = None,
    cameras: tuple[Camera, Camera] | None = None,
    pictures: tuple[OverlayPicture, ...] = (),
    stage_s: dict[str, float] | None = None,
    exchange: np.ndarray | None = None,
) -> Episode:
    """An episode with the given truth and estimates (F, 3, 3) [m]; NaN: waiting.

    exchange (F,): stated probability that the hands are exchanged.
    """
    rig = cameras or make_cameras()
    centres = make_paths(frames, fps) if centres_m is None else centres_m
    estimates = centres if estimates_m is None else estimates_m
    outcomes = []
    for f, (truth_m, said_m) in enumerate(zip(centres, estimates, strict=True)):
        pairs = merged(f) if merged else (NEVER_MERGED, NEVER_MERGED)
        status = tuple("tracked" if np.isfinite(p).all() else "waiting" for p in said_m)
        stated = np.nan if exchange is None else float(exchange[f])
        P = np.tile(np.eye(3) * 1e-4, (3, 1, 1))
        said = Estimates(said_m, P, np.zeros((3, 3)), status, stated)
        truth = make_truth(f, f / fps, truth_m, rig, pairs, labels(f) if labels else ())
        seen = tuple(seen_in(view.centroids_px) for view in truth.views)
        outcomes.append(
            FrameOutcome(
                truth, said, seen, stage_s or {"render": 0.03, "detect": 0.02, "track": 0.004}
            )
        )
    return Episode(
        scenario,
        group,
        seed,
        fps,
        rig,
        tuple(outcomes),
        digest=f"digest-{scenario}-{seed}",
        values={"speed": 0.2, "object": "can"},
        pictures=pictures,
    )


def seen_in(centres_px: np.ndarray) -> Detections:
    """An ellipse per target."""
    n = len(centres_px)
    shape = np.array([[40.0, 30.0, 1.2], [22.0, 14.0, 0.3], [22.0, 14.0, 2.7]])[:n]
    return Detections(
        centres_px,
        np.tile(np.eye(2) * 4, (n, 1, 1)),
        np.column_stack([centres_px, shape]),
        np.full(n, 1500.0),
    )


def noisy(centres_m: np.ndarray, seed: int, sigma_m: float = 0.012) -> np.ndarray:
    """Estimates about the truth."""
    return centres_m + np.random.default_rng(seed).normal(0, sigma_m, centres_m.shape)


def make_picture(seed: int = 0) -> np.ndarray:
    """A BGR picture of nothing in particular, (480, 640, 3)."""
    rng = np.random.default_rng(seed)
    small = rng.integers(70, 150, (6, 8, 3)).astype(np.uint8)
    return cv2.resize(small, (640, 480), interpolation=cv2.INTER_CUBIC)


@pytest.fixture(scope="session")
def episode_of() -> Callable[..., Episode]:
    return make_episode


@pytest.fixture(scope="session")
def tools() -> Any:
    """The other makers by name, since test folders are no packages."""
    from types import SimpleNamespace

    return SimpleNamespace(
        cameras=make_cameras,
        paths=make_paths,
        truth=make_truth,
        noisy=noisy,
        picture=make_picture,
        seen=seen_in,
    )


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """One Chromium for the tests of a module."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on PATH")
    sync_api = pytest.importorskip("playwright.sync_api")
    switches = "no-sandbox disable-quic disable-background-networking disable-component-update"
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium,
            args=[f"--{name}" for name in [*switches.split(), "disable-webgl"]],
        )
        yield browser
        browser.close()


@pytest.fixture
def opened(browser: Any) -> Callable[..., Any]:
    """A page in the browser, whose complaints and requests to a network fail the test.

    Its reader prefers reduced motion, so that nothing moves or scrolls on while a test acts.
    """

    @contextmanager
    def opened(
        path: Any,
        ready: str,
        schemes: tuple[str, ...] = ("file:", "data:", "blob:"),
        **settings: Any,
    ) -> Iterator[Any]:
        complaints: list[str] = []
        requests: list[str] = []
        view = browser.new_page(**{"reduced_motion": "reduce"} | settings)
        view.set_default_timeout(120_000)  # a busy machine is no fault of the page
        view.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
        view.on("pageerror", lambda e: complaints.append(str(e)))
        view.on("request", lambda r: requests.append(r.url))
        view.goto(path.as_uri())
        view.wait_for_selector(ready)
        yield view
        view.close()
        assert complaints == []
        assert all(url.startswith(schemes) for url in requests)

    return opened
