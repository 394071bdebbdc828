"""Blob detector: skin components with their looks, for a tracker that splits them itself."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple, final

import cv2
import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.camera import Camera, project, to_camera, undistort_points
from pjpdaf.detector.adaptation import AdaptationParameters, BlobDetectorParameters
from pjpdaf.detector.alignment import Alignment, moved
from pjpdaf.detector.background import Background, BackgroundSums, BackgroundTest, prepare
from pjpdaf.detector.chroma import ChromaTest
from pjpdaf.detector.cloth import cloth_mask
from pjpdaf.detector.components import Segments
from pjpdaf.detector.detector import SkinDetector, numbered, skin_of
from pjpdaf.detector.discs import opened_by
from pjpdaf.detector.ellipses import ellipse_axes, moments, undistort_moments
from pjpdaf.detector.exposure import Exposure
from pjpdaf.detector.face import (
    ExpectedHead,
    Face,
    HeadPlace,
    face_in,
    head_place,
    mean_face,
    to_reference,
)
from pjpdaf.detector.ghost import GhostTest
from pjpdaf.detector.guidance import ANY, Guidance, Scope
from pjpdaf.detector.parameters import DetectorParameters
from pjpdaf.detector.silhouette import foreground, opened, reduced, reduction, silhouette, turned
from pjpdaf.detector.skin import skin_mask, to_hsv
from pjpdaf.detector.small_picture import SmallPicture
from pjpdaf.detector.still_scene import SCENE_FRAMES, StillScene, still_scene
from pjpdaf.frames import StereoFrame
from pjpdaf.interfaces import Detections, Estimates
from pjpdaf.looks import BlobLooks
from pjpdaf.targets import HEAD

LATTICE_COLUMNS = 213  # pixels of a blob are kept on a lattice of about this many columns
THIN = 0.5  # half-width of a finger over that of a palm, at most; a wrist's is about 0.7
NEAREST_HEAD_M = 0.2  # depth of a head that can be looked for
QUIETER = 0.8, 0.6  # floors of the deviations of S and V: averaging takes most of the noise out


class View(NamedTuple):
    """A view: picture uint8 (h, w, 3) as searched; once a background is learnt the reduced picture,
    foreground, and that by chroma, uint8; face, and where it was looked for.
    """

    picture: np.ndarray
    small: SmallPicture | None = None
    person: np.ndarray | None = None
    coloured: np.ndarray | None = None
    face: Face | None = None
    place: HeadPlace | None = None


@final
@dataclass(frozen=True, eq=False)
class BlobDetector:
    """Skin components, each a detection, with pixels and silhouette; no clustering.

    A frame's detections depend on its pictures and on the background alone: no memory of earlier
    frames. base: the thesis's detector, which segments; its 'undistort' and 'clusters' have no
    effect. small: backgrounds of the reduced pictures, of the views as learnt, or empty;
    exposures: how each view's pictures are smoothed, or empty; alignment: rotation of the second
    view that its calibration missed: detections are given as a camera as calibrated would see them.
    adaptation: which of these parts are on.
    """

    base: SkinDetector
    small: tuple[Background, ...] = ()
    exposures: tuple[Exposure, ...] = ()
    alignment: Alignment | None = None
    adaptation: AdaptationParameters = field(default_factory=AdaptationParameters)
    _tests: tuple[BackgroundTest, ...] = field(init=False, repr=False)
    _chroma: tuple[ChromaTest, ...] = field(init=False, repr=False)
    _ghosts: tuple[GhostTest, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        p = self.base.parameters.background
        quiet = dataclasses.replace(
            p, sat_sd_floor=QUIETER[0] * p.sat_sd_floor, val_sd_floor=QUIETER[1] * p.val_sd_floor
        )
        object.__setattr__(self, "_tests", tuple(prepare(b, quiet) for b in self.small))
        object.__setattr__(self, "_chroma", tuple(ChromaTest.of(b) for b in self.small))
        watched = self.small if self.adaptation.drop_ghosts else ()
        object.__setattr__(self, "_ghosts", tuple(GhostTest.of(b) for b in watched))

    @staticmethod
    def of(cameras: tuple[Camera, ...], parameters: DetectorParameters) -> BlobDetector:
        """Return a detector that has learnt no background yet."""
        base = SkinDetector(cameras, parameters)
        if isinstance(parameters, BlobDetectorParameters):
            return BlobDetector(base, adaptation=parameters.adaptation)
        return BlobDetector(base)

    def learn(
        self, background: Iterable[StereoFrame], scene: StillScene | None = None
    ) -> BlobDetector:
        """Return a detector that knows the person-free scene.

        scene: of this background, where it is known. The first SCENE_FRAMES frames are kept to look
        at it, all others are read one at a time. Raises BenchError where a view has fewer than
        background_learn_min pictures.
        """
        frames = iter(background)
        first = list(itertools.islice(frames, SCENE_FRAMES))
        for frame in first:
            self.base.checked(frame)
        adapt = self.adaptation
        exposures, alignment = scene or still_scene(
            first,
            self.base.cameras,
            smooth_noise=adapt.smooth_noise,
            align_views=adapt.align_views,
        )
        sums = tuple(BackgroundSums() for _ in self.base.cameras)

        def watched() -> Iterable[StereoFrame]:
            for frame in itertools.chain(first, frames):
                checked = self.base.checked(frame)
                smooth = tuple(
                    None if picture is None else exposures[view](picture)
                    for view, picture in enumerate(checked)
                )
                for view, picture in enumerate(smooth):
                    if picture is not None:
                        sums[view].add(reduced(picture))
                yield dataclasses.replace(frame, pictures=smooth)

        base = self.base.learn(watched())
        least = base.parameters.background.background_learn_min
        return BlobDetector(base, tuple(s.result(least) for s in sums), exposures, alignment, adapt)

    def __call__(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[Detections, ...]:
        """Return the detections of each view. predicted: for the depth that scales min_area_px.

        Raises BenchError for a picture of the wrong size or type; a missing picture is `missing`.
        """
        return self.detect(frame, predicted)[0]

    @property
    def recipe(self) -> str:
        """All parameters, as a text."""
        return repr((type(self).__name__, self.base.recipe, self.adaptation))

    def guidance(self, predicted: Estimates | None) -> tuple[Guidance, ...]:
        """Return what each view's detections take from a prediction."""
        return tuple(
            Guidance(area.min_area_px, self._expected(view, predicted))
            for view, area in enumerate(self.base.guidance(predicted))
        )

    def detect(
        self, frame: StereoFrame, predicted: Estimates | None = None
    ) -> tuple[tuple[Detections, ...], tuple[Scope, ...]]:
        """Return the detections of each view, and the guidance for which each is the same.

        The face is that of all views: a frame's detections are the same where all scopes hold.
        """
        pictures = [
            picture if picture is None or not self.exposures else self.exposures[view](picture)
            for view, picture in enumerate(self.base.checked(frame))
        ]
        guidance = self.guidance(predicted)
        views = [
            None if p is None else self._view(v, p, guidance[v].head)
            for v, p in enumerate(pictures)
        ]
        face = mean_face([v.face for v in views if v is not None and v.face is not None])
        found = [
            (Detections.none(missing=True), ANY)
            if view is None
            else self._detect(number, view, face, guidance[number].min_area_px)
            for number, view in enumerate(views)
        ]
        detections, scopes = zip(*found, strict=True)
        return detections, scopes

    def _expected(self, view: int, predicted: Estimates | None) -> ExpectedHead | None:
        """Where the reduced picture of a view shows the head, None where it is not tracked."""
        if predicted is None or not self.adaptation.expect_face:
            return None
        camera, head_m = self.base.cameras[view], predicted.positions_m[HEAD]
        depth_m = float(to_camera(camera, head_m)[2])
        if predicted.status[HEAD] != "tracked" or not depth_m > NEAREST_HEAD_M:
            return None
        step = reduction(camera.width_px)
        centre_px = (project(camera, head_m) + 0.5) / step - 0.5
        return ExpectedHead(centre_px, float(camera.K[0, 0]) / depth_m / step)

    def _view(self, view: int, picture: np.ndarray, expected: ExpectedHead | None) -> View:
        if not self._tests:
            return View(picture)
        small = SmallPicture.of(reduced(picture))
        person, coloured = foreground(small.hsv, self._tests[view]), None
        if self.adaptation.test_chroma:
            coloured = self._chroma[view](small)
            person |= opened(coloured)
        focal_px = self._small_focal_px(view, picture)
        shoulders = self.adaptation.to_shoulders
        place, inside = head_place(person, focal_px, expected, shoulders)
        face = None if inside is None else face_in(inside, small.bgr, self._chroma[view].median)
        return View(picture, small, person, coloured, face, place)

    def _no_skin(self, number: int, view: View, face: Face | None) -> np.ndarray | None:
        """Clothes of the colour of skin and ghosts in the reduced picture, None without any."""
        cloth = self._cloth(number, view, face)
        ghost = None
        if view.small is not None and self._ghosts:
            ghost = self._ghosts[number](view.small)
        if ghost is None:
            return cloth
        return ghost if cloth is None else np.asarray(ghost | cloth)

    def _cloth(self, number: int, view: View, face: Face | None) -> np.ndarray | None:
        """Clothes of the colour of skin in the reduced picture, None without any."""
        small, person, p = view.small, view.person, self.base.parameters
        if small is None or person is None or face is None or not self.adaptation.split_clothes:
            return None
        balance = self.adaptation.balance_light and not face.fits
        hsv = to_hsv(to_reference(small.bgr, face)) if balance else small.hsv
        skin = (skin_mask(hsv, p.skin) > 0) & (person > 0)
        focal_px = self._small_focal_px(number, view.picture)
        return cloth_mask(small.logs, skin, face, focal_px, self.adaptation.clear_clothes)

    def _small_focal_px(self, number: int, picture: np.ndarray) -> float:
        return float(self.base.cameras[number].K[0, 0]) / reduction(picture.shape[1])

    def _detect(
        self, number: int, view: View, face: Face | None, min_area_px: float
    ) -> tuple[Detections, Scope]:
        p, camera = self.base.parameters, self.base.cameras[number]
        picture = view.picture
        balance = face is not None and self.adaptation.balance_light and not face.fits
        balanced = to_reference(picture, face) if face is not None and balance else None
        no_skin = self._no_skin(number, view, face)
        seen = self.base.segment(number, picture, min_area_px, balanced, view.coloured, no_skin)
        scope = Scope(seen.above_px, seen.upto_px, view.place)
        turn = self.alignment.homography(camera) if self.alignment and number == 1 else None
        mask = skin_of(seen)
        shape = silhouette(view.person, mask, camera)
        if turn is not None:
            shape = turned(shape, turn)
        if seen.count == 0:
            none = np.zeros((0, 2))
            nothing = BlobLooks((), 1.0, none, none, shape)
            return dataclasses.replace(Detections.none(), looks=nothing), scope
        fit = undistort_moments(camera, moments(seen.points, seen.component, seen.count))
        covariances = np.broadcast_to(p.centre_sd_px**2 * np.eye(2), (len(fit), 2, 2))
        numbers = numbered(seen)
        pixels, each = _lattice(numbers, seen.count, camera)
        if turn is not None:
            fit = dataclasses.replace(fit, centres=moved(fit.centres, turn))
            pixels = tuple(moved(points, turn) for points in pixels)
        found = Detections(
            fit.centres,
            covariances,
            ellipse_axes(fit),
            fit.areas,
            mask=mask if self.base.keep_masks else None,
            looks=BlobLooks(pixels, each, *directions(seen, numbers), shape),
        )
        return found, scope


def directions(seen: Segments, numbers: np.ndarray) -> tuple[Floats, Floats]:
    """Vectors of each component (count, 2), over sqrt(area): `BlobLooks.palms` and `fingers`.

    The palm is the middle of where the component is widest: the tops of its distance transform.
    Thin is what an opening by a disc of THIN of that width takes away. numbers: as of `numbered`.
    """
    palms, thin_parts = np.zeros((seen.count, 2)), np.zeros((seen.count, 2))
    # Columns of their own: numpy reduces an axis of 2 slowly.
    columns, rows = np.ascontiguousarray(seen.points.T)
    for i in range(seen.count):
        at = np.flatnonzero(seen.component == i)
        x, y = columns[at], rows[at]
        low = left, top = int(x.min()), int(y.min())
        window = numbers[top : int(y.max()) + 1, left : int(x.max()) + 1] == i + 1
        # A rim of 1 px all round.
        width = window.shape[1] + 2
        inside = np.zeros((len(window) + 2, width), np.uint8)
        inside[1:-1, 1:-1] = window
        depth = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
        deepest = depth.max()
        tops = np.divmod(np.flatnonzero(depth > 0.9 * deepest), width)
        widest = np.array([tops[1].sum(), tops[0].sum()]) / len(tops[0])
        root = len(at) ** 0.5
        palms[i] = (np.array([x.sum(), y.sum()]) / len(at) - (widest - 1 + np.array(low))) / root
        size = 2 * max(1, round(THIN * float(deepest))) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
        rest = inside - opened_by(disc, inside)
        thin_at = np.flatnonzero(rest.view(np.bool_))
        if len(thin_at):
            down, right = np.divmod(thin_at, width)
            thin = np.array([(right - widest[0]).sum(), (down - widest[1]).sum()])
            thin_parts[i] = thin / len(at) / root
    return palms, thin_parts


def _lattice(numbers: np.ndarray, count: int, camera: Camera) -> tuple[tuple[Floats, ...], float]:
    """Each component's pixels on a lattice, undistorted, and how many pixels one stands for.

    numbers: as of `numbered`, of `count` components.
    """
    step = max(1, round(camera.width_px / LATTICE_COLUMNS))
    on = np.ascontiguousarray(numbers[::step, ::step])
    at = np.flatnonzero(on > 0)
    rows, columns = np.divmod(at, on.shape[1])
    points = undistort_points(camera, step * np.column_stack([columns, rows]))
    number = on.reshape(-1).take(at)
    return tuple(points[number == i + 1] for i in range(count)), float(step * step)
