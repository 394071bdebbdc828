# /// script
# requires-python = ">=3.10,<3.13"
# dependencies = ["mediapipe==0.10.21"]
# ///
"""MediaPipe's Hands and Pose on every picture of a data set: 3-D tracks, and 2-D detections.

    uv run examples/peers/mediapipe_tracks.py DATASET --out DIR

or, in an environment of its own (Python 3.12 at most; never beside this project, since it brings
another NumPy and another OpenCV):

    python3.12 -m venv peer && peer/bin/pip install mediapipe==0.10.21
    peer/bin/python examples/peers/mediapipe_tracks.py DATASET --out DIR

It reads what is on disk (`left/`, `right/`, `rig.json`) and nothing of this project. It writes

    DIR/tracks.csv      world positions, for `pjpdaf-bench score DATASET DIR/tracks.csv`
    DIR/detections.csv  centres in the pictures, one row a view and target, in pixels as filmed

Every picture is seen for itself: no filter, no memory. A hand is the mean of its wrist and
knuckles; it is the person's hand whose wrist, by Pose, is nearest. The head is the mean of both
ears. A target is triangulated where both views show it (two rays, the point between them).
"""

import argparse
import csv
import json
import time
from pathlib import Path

import cv2
import mediapipe as mp
import numpy as np

TARGETS = ("head", "right_hand", "left_hand")
VIEWS = ("left", "right")
PALM = (0, 5, 9, 13, 17)  # wrist and knuckles of Hands' 21 landmarks
EARS, WRISTS = (7, 8), {"right_hand": 16, "left_hand": 15}  # of Pose's 33; the person's own sides
PALM_OF_POSE = {"right_hand": (16, 18, 20), "left_hand": (15, 17, 19)}  # wrist, little, index
LEAST_VISIBILITY = 0.5


class Peer:
    """Both models, on single pictures."""

    def __init__(self, least_confidence=0.3):
        solutions = mp.solutions
        self.hands = solutions.hands.Hands(
            static_image_mode=True, max_num_hands=2, min_detection_confidence=least_confidence
        )
        self.pose = solutions.pose.Pose(static_image_mode=True, model_complexity=1)

    def __call__(self, picture_bgr):
        """Centres (x, y) [px] and scores of the targets that are seen: {target: (x, y, score)}."""
        rgb = np.ascontiguousarray(picture_bgr[..., ::-1])
        size = np.array([rgb.shape[1], rgb.shape[0]], float)
        body = self.pose.process(rgb).pose_landmarks
        if body is None:
            return {}

        def points(landmarks, which):
            # Landmarks are in shares of the picture, from its corner: pixel 0's centre is at 0.5.
            return np.array([[landmarks[i].x, landmarks[i].y] for i in which]) * size - 0.5

        seen = {}
        ears = min(body.landmark[i].visibility for i in EARS)
        if ears >= LEAST_VISIBILITY:
            seen["head"] = (*points(body.landmark, EARS).mean(axis=0), ears)
        found = self.hands.process(rgb)
        palms = [
            points(hand.landmark, PALM).mean(axis=0) for hand in found.multi_hand_landmarks or []
        ]
        sides = [hand.classification[0] for hand in found.multi_handedness or []]
        wrists = {name: points(body.landmark, [i])[0] for name, i in WRISTS.items()}
        for name, palm in assigned(palms, sides, wrists).items():
            seen[name] = (*palm, 1.0)
        for name, which in PALM_OF_POSE.items():  # a hand that only Pose sees
            visible = min(body.landmark[i].visibility for i in which)
            if name not in seen and visible >= LEAST_VISIBILITY:
                seen[name] = (*points(body.landmark, which).mean(axis=0), visible / 2)
        return seen


def assigned(palms, sides, wrists):
    """Each palm to a hand: {target: palm}.

    Hands says of each palm which hand it is, taking the picture for a mirror: its "Left" is the
    person's right hand here. Where it says the same of both palms, or sees one alone, Pose's
    wrists decide.
    """
    named = ["right_hand" if side.label == "Left" else "left_hand" for side in sides]
    if len(set(named)) == 2:
        return dict(zip(named, palms, strict=True))
    names = list(wrists)
    far = [[np.linalg.norm(palm - wrists[name]) for name in names] for palm in palms]
    if len(palms) == 2:
        straight = far[0][0] + far[1][1] <= far[0][1] + far[1][0]
        return dict(zip(names, palms if straight else palms[::-1], strict=True))
    return {names[int(np.argmin(row))]: palm for row, palm in zip(far, palms, strict=True)}


def triangulate(seen, cameras):
    """A point (3,) in the world from its pixels in both views."""
    rays = []
    for (x, y, _), camera in zip(seen, cameras, strict=True):
        K, D = np.array(camera["K"]), np.array(camera["distortion"], float)
        plain = cv2.undistortPoints(np.array([[[x, y]]]), K, D if len(D) else None)
        rays.append(plain.reshape(2, 1))
    matrices = [np.column_stack([camera["R_cw"], camera["t_cw"]]) for camera in cameras]
    point = cv2.triangulatePoints(*matrices, *rays)[:, 0]
    return point[:3] / point[3]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    folders = sorted(arguments.dataset.glob("seq_*"))
    if not folders:
        parser.error(f"{arguments.dataset}: no folders seq_*; give a data set of `dataset make`")
    arguments.out.mkdir(parents=True, exist_ok=True)
    peer, frames, spent_s = Peer(), 0, 0.0
    with (
        (arguments.out / "tracks.csv").open("w", newline="") as tracks_file,
        (arguments.out / "detections.csv").open("w", newline="") as detections_file,
    ):
        tracks, detections = csv.writer(tracks_file), csv.writer(detections_file)
        tracks.writerow(["sequence", "frame", "target", "x_m", "y_m", "z_m"])
        names = [f"evidence_{name}" for name in TARGETS]
        detections.writerow(["sequence", "frame", "view", "u_px", "v_px", "score", *names])
        for folder in folders:
            rig = json.loads((folder / "rig.json").read_text())
            cameras = [rig["calibration"][view] for view in VIEWS]
            for index in range(rig["frames"]):
                both = []
                for view in VIEWS:
                    picture = cv2.imread(str(folder / view / f"{index + 1:06d}.png"))
                    begun = time.process_time()
                    both.append({} if picture is None else peer(picture))
                    spent_s += time.process_time() - begun
                    for name, (x, y, score) in both[-1].items():
                        # Which target it is, as log-likelihoods: sure, but not beyond doubt.
                        evidence = [0.0 if name == other else -3.0 for other in TARGETS]
                        row = [folder.name, index, view, f"{x:.3f}", f"{y:.3f}", f"{score:.3f}"]
                        detections.writerow(row + evidence)
                frames += 1
                for name in TARGETS:
                    if all(name in seen for seen in both):
                        point = triangulate([seen[name] for seen in both], cameras)
                        if np.isfinite(point).all() and np.abs(point).max() < 10:
                            cells = [f"{value:.6f}" for value in point]
                            tracks.writerow([folder.name, index, name, *cells])
            print(f"{folder.name}: {rig['frames']} frames")
    print(f"{frames} stereo frames, {1000 * spent_s / max(frames, 1):.0f} ms CPU each")


if __name__ == "__main__":
    main()
