"""YOLO's files, read by a small parser of its format: the library itself pulls torch and OpenCV.

The format is that of Ultralytics' documentation: a line is a class and numbers as shares of the
picture's width and height. What is read is compared with COCO's files, read by pycocotools.
"""

import cv2
import numpy as np
import pytest
from pycocotools import mask as mask_utils
from pycocotools.coco import COCO
from ruamel.yaml import YAML

from sim.dataset.export import coco, yolo
from sim.dataset.splits import splits_record
from sim.scene.world import CAMERAS

pytestmark = pytest.mark.filterwarnings(
    "ignore:__array__ implementation doesn't accept a copy keyword:DeprecationWarning"
)


@pytest.fixture(scope="module")
def exported(dataset, tmp_path_factory):
    into = tmp_path_factory.mktemp("yolo")
    for one in (yolo.pose, yolo.segmentation, coco.export):
        one(dataset, into)
    return into


@pytest.fixture(scope="module")
def annotations(exported):
    """COCO's images and their annotations by the name that YOLO's files have."""
    found = {}
    for camera in CAMERAS:
        file = COCO(exported / "annotations" / f"instances_{camera}.json")
        for number, image in file.imgs.items():
            name = f"{image['sequence']}_{camera}_{image['frame_index'] + 1:06d}"
            found[name] = file, image, {a["track_id"]: a for a in file.imgToAnns[number]}
    return found


def parsed(path):
    lines = [line.split() for line in path.read_text().splitlines()]
    return [(int(words[0]), np.array(words[1:], float)) for words in lines]


def texts(folder):
    return {path.stem: path for path in sorted(folder.glob("labels/*/*.txt"))}


@pytest.mark.parametrize("task", ["yolo-pose", "yolo-seg"])
def test_every_picture_has_its_text_and_is_the_data_sets_own(dataset, exported, annotations, task):
    folder = exported / task
    pictures = {path.stem: path for path in folder.glob("images/*/*.png")}
    assert set(pictures) == set(texts(folder)) == set(annotations)
    for name, path in pictures.items():
        assert texts(folder)[name].parts[-2] == path.parts[-2]  # the same split
        original = dataset.folder / annotations[name][1]["file_name"]
        assert path.read_bytes() == original.read_bytes()
        assert not path.is_symlink()


def test_splits_are_those_of_the_data_set(dataset, exported):
    wanted = splits_record(dataset.sequences)["splits"]
    for split, names in wanted.items():
        there = {p.stem[:10] for p in (exported / "yolo-pose" / "images" / split).glob("*.png")}
        assert there == set(names)


def test_data_yaml_says_what_ultralytics_wants(exported):
    pose = YAML(typ="safe").load(exported / "yolo-pose" / "data.yaml")
    assert pose["kpt_shape"] == [21, 3]
    assert pose["names"] == {0: "right_hand", 1: "left_hand"}
    assert len(pose["flip_idx"]) == 21
    assert (exported / "yolo-pose" / pose["train"]).is_dir()
    seg = YAML(typ="safe").load(exported / "yolo-seg" / "data.yaml")
    assert seg["names"] == {0: "head", 1: "right_hand", 2: "left_hand"}


def test_poses_are_cocos(exported, annotations):
    seen = 0
    for name, path in texts(exported / "yolo-pose").items():
        _, image, tracks = annotations[name]
        size = np.array([image["width"], image["height"]])
        hands = dict(parsed(path))
        assert {2 + number for number in hands} == {2, 3} & set(tracks)
        for number, values in hands.items():
            one = tracks[2 + number]
            middle, extent = values[:2] * size, values[2:4] * size
            box = [*(middle - extent / 2), *extent]
            np.testing.assert_allclose(box, one["bbox"], atol=1e-3)
            joints = values[4:].reshape(21, 3)
            expected = np.reshape(one["keypoints"], (21, 3))
            np.testing.assert_array_equal(joints[:, 2], expected[:, 2])
            known = expected[:, 2] > 0
            # YOLO counts from the picture's corner, COCO's keypoints here from a pixel's centre.
            places = joints[known, :2] * size - 0.5
            np.testing.assert_allclose(places, expected[known, :2], atol=2e-3)
            assert not joints[~known].any()
            assert (values >= 0).all()
            seen += 1
    assert seen > 40


def test_polygons_fill_cocos_masks(exported, annotations):
    seen = 0
    for name, path in texts(exported / "yolo-seg").items():
        _, image, tracks = annotations[name]
        size = np.array([image["width"], image["height"]])
        for number, values in parsed(path):
            # Some readers cut off the fraction of a pixel, others round.
            pixels = values.reshape(-1, 2) * size
            corners = pixels.astype(np.int32)
            np.testing.assert_array_equal(corners, np.rint(pixels))
            np.testing.assert_allclose(corners, pixels - 0.5, atol=0.02)
            drawn = np.zeros(size[::-1], np.uint8)
            cv2.fillPoly(drawn, [corners], 1)
            mask = mask_utils.decode(tracks[1 + number]["segmentation"])
            union = np.count_nonzero(drawn | mask)
            off = np.count_nonzero(drawn != mask) / union
            # Lines join the parts of a face behind the rims of glasses.
            assert off < (0.02 if number else 0.06) or np.count_nonzero(drawn != mask) < 8
            seen += 1
    assert seen > 80


def test_parts_and_holes_are_one_polygon():
    mask = np.zeros((40, 60), bool)
    mask[5:30, 5:30] = True
    mask[12:20, 12:20] = False
    mask[8:20, 40:55] = True
    corners = yolo.polygon(mask).astype(np.int32)
    drawn = np.zeros(mask.shape, np.uint8)
    cv2.fillPoly(drawn, [corners], 1)
    # The way between the parts is a line a pixel wide.
    assert np.count_nonzero(drawn.astype(bool) & ~mask) < 45
    assert not (mask & ~drawn.astype(bool)).any()
    assert not drawn[13:19, 13:19].all()
