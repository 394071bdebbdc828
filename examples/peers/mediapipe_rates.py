# /// script
# requires-python = ">=3.10,<3.13"
# dependencies = ["mediapipe==0.10.21"]
# ///
"""How often MediaPipe's models, trained on real people, find person, hands and face in a data set.

    pjpdaf-bench dataset make cross drink --out sets/real --labels seg --export coco
    uv run examples/peers/mediapipe_rates.py sets/real

or in an environment of its own, as `mediapipe_tracks.py` beside it says. Every picture of both
views is seen for itself. It reads the pictures and `annotations/` (COCO), and nothing of this
project; it prints a table in Markdown.

A hand counts where 60 % or more of it is seen, and is found where the mean of its wrist and
knuckles lies in the box of its visible skin, 12 pixels around it included; a face counts where
70 % or more is seen, and is found where the middle of its box does.
"""

import argparse
import json
from collections import Counter
from pathlib import Path

import cv2
import mediapipe as mp
import numpy as np

PALM = (0, 5, 9, 13, 17)  # wrist and knuckles of Hands' 21 landmarks
LEAST_SEEN = {"head": 0.7, "right_hand": 0.6, "left_hand": 0.6}
NEAR_PX, PIECE_PX, HEADS = 12, 200, 1.6
PERSON, HAND, HAND_PIECE = "the person (Pose)", "a hand (Hands)", "a hand, in 200 x 200 pixels"
FACE_FAR, FACE_NEAR = "a face (full range)", "a face (short range)"
FACE_PIECE = "a face (short range), in a piece of 1.6 heads to each side"


class Models:
    """Each model's answer for one picture, as points in its pixels."""

    def __init__(self):
        self._pose = mp.solutions.pose.Pose(static_image_mode=True, model_complexity=1)
        self._hands = mp.solutions.hands.Hands(
            static_image_mode=True, max_num_hands=2, min_detection_confidence=0.3
        )
        self._faces = [mp.solutions.face_detection.FaceDetection(0.5, which) for which in (0, 1)]

    def person(self, picture_rgb):
        return self._pose.process(picture_rgb).pose_landmarks is not None

    def palms(self, picture_rgb):
        """Means of wrist and knuckles, a point (2,) each."""
        found = self._hands.process(picture_rgb).multi_hand_landmarks or []
        points = [[(hand.landmark[i].x, hand.landmark[i].y) for i in PALM] for hand in found]
        return [_pixels(np.mean(each, axis=0), picture_rgb) for each in points]

    def faces(self, picture_rgb, full_range):
        """Middles of faces, a point (2,) each."""
        found = self._faces[full_range].process(picture_rgb).detections or []
        boxes = [face.location_data.relative_bounding_box for face in found]
        return [
            _pixels((box.xmin + box.width / 2, box.ymin + box.height / 2), picture_rgb)
            for box in boxes
        ]


def _pixels(share, picture):
    """A place in shares of a picture, from its corner, in pixels: pixel 0's centre is at 0.5."""
    return np.asarray(share) * picture.shape[1::-1] - 0.5


def hit(points, box):
    """Whether one of the points lies in a box (x, y, width, height), or near it."""
    low = np.array(box[:2]) - NEAR_PX
    high = low + np.array(box[2:]) + 2 * NEAR_PX
    return any((low <= point).all() and (point <= high).all() for point in points)


def piece(picture, box, size):
    """A square of the picture about a box's middle, and the box in its pixels."""
    middle = np.array(box[:2]) + np.array(box[2:]) / 2
    low = np.maximum(np.round(middle - size / 2).astype(int), 0)
    cut = picture[low[1] : low[1] + int(size), low[0] : low[0] + int(size)]
    return np.ascontiguousarray(cut), [box[0] - low[0], box[1] - low[1], *box[2:]]


def look(models, picture, shown):
    """What is asked of one picture, and whether it was found: pairs (question, bool)."""
    if any(name == "person" for name, _, _ in shown):
        yield PERSON, models.person(picture)
    palms = models.palms(picture)
    faces = {far: models.faces(picture, far) for far in (0, 1)}
    for name, box, seen in shown:
        if seen < LEAST_SEEN.get(name, 2.0):
            continue
        if name == "head":
            cut, inside = piece(picture, box, 2 * HEADS * box[3])
            yield FACE_FAR, hit(faces[1], box)
            yield FACE_NEAR, hit(faces[0], box)
            yield FACE_PIECE, hit(models.faces(cut, 0), inside)
        else:
            cut, inside = piece(picture, box, PIECE_PX)
            yield HAND, hit(palms, box)
            yield HAND_PIECE, hit(models.palms(cut), inside)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    folder = parser.parse_args().dataset
    files = sorted(folder.glob("annotations/instances_*.json"))
    if not files:
        parser.error(f"{folder}: no annotations/; `dataset export {folder} --to coco` makes them")
    models, asked, found = Models(), Counter(), Counter()
    for file in files:
        coco = json.loads(file.read_text())
        names = {category["id"]: category["name"] for category in coco["categories"]}
        shown = {image["id"]: [] for image in coco["images"]}
        for each in coco["annotations"]:
            seen = each.get("visible_fraction", 1.0)
            shown[each["image_id"]].append((names[each["category_id"]], each["bbox"], seen))
        for image in coco["images"]:
            picture = cv2.imread(str(folder / image["file_name"]))[..., ::-1]
            for question, answer in look(models, np.ascontiguousarray(picture), shown[image["id"]]):
                asked[question] += 1
                found[question] += answer
    print("| found | n | share |\n|---|--:|--:|")
    for question, n in asked.items():
        print(f"| {question} | {n} | {100 * found[question] / n:.1f} % |")


if __name__ == "__main__":
    main()
