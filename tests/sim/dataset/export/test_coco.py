"""COCO's files, read by pycocotools."""

import json
import sys

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from pycocotools import mask as mask_utils
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

import sim.dataset
from pjpdaf.errors import BenchError
from pjpdaf.targets import TARGETS
from sim.dataset.export.coco import export
from sim.dataset.export.coco_ids import FIRST_OBJECT_CATEGORY, OBJECT_KINDS
from sim.dataset.labels.instances import PERSON
from sim.scene.objects import KINDS
from sim.scene.world import CAMERAS

HANDS = [2, 3]
ORDER = ("person", "right_hand", "left_hand")  # of the rows of a frame
# pycocotools' own, with numpy 2.
pytestmark = pytest.mark.filterwarnings(
    "ignore:__array__ implementation doesn't accept a copy keyword:DeprecationWarning"
)


@pytest.fixture(scope="module")
def files(dataset, tmp_path_factory):
    return export(dataset, tmp_path_factory.mktemp("coco"))


@pytest.fixture(scope="module", params=CAMERAS)
def view(request):
    return CAMERAS.index(request.param)


@pytest.fixture(scope="module")
def coco(files, view):
    return COCO(files[view])


def sequence_of(dataset, image):
    return next(one for one in dataset.sequences if one.name == image["sequence"])


def test_every_visible_thing_is_there_with_its_mask_bit_for_bit(dataset, coco, view):
    found = 0
    for number, image in coco.imgs.items():
        sequence = sequence_of(dataset, image)
        seg = sequence.seg(view, image["frame_index"])
        things = [one.id for one in sequence.instances if one.kind in ("target", "object")]
        said = coco.imgToAnns[number]
        shown = {*(set(things) & set(np.unique(seg))), PERSON}
        assert sorted(one["track_id"] for one in said) == sorted(shown)
        for one in said:
            own = seg == one["track_id"]
            if one["track_id"] == PERSON:  # whole: with head and hands
                own = np.isin(seg, [1, 2, 3, 4])
            np.testing.assert_array_equal(coco.annToMask(one), own)
        found += len(said)
    assert found == len(coco.anns) > 4 * 15 - 5


def test_boxes_are_those_of_the_truth_and_of_pycocotools(dataset, coco, view):
    for one in coco.anns.values():
        assert one["area"] == mask_utils.area(one["segmentation"])
        assert one["bbox"] == mask_utils.toBbox(one["segmentation"]).tolist()
        image = coco.imgs[one["image_id"]]
        if one["track_id"] <= len(TARGETS):
            truth = sequence_of(dataset, image).truths[image["frame_index"]].views[view]
            target = one["track_id"] - 1
            assert one["bbox"] == truth.boxes_px[target].tolist()
            assert one["visible_fraction"] == pytest.approx(
                truth.visible_fractions[target], abs=1e-6
            )


def test_amodal_masks_are_those_of_the_data_set(dataset, coco, view):
    for one in coco.anns.values():
        if one["track_id"] > len(TARGETS):
            assert "amodal_segmentation" not in one
            continue
        image = coco.imgs[one["image_id"]]
        masks = sequence_of(dataset, image).amodal(view, image["frame_index"])
        mask = mask_utils.decode(one["amodal_segmentation"])
        np.testing.assert_array_equal(mask, masks[one["track_id"] - 1])
        assert one["amodal_bbox"] == mask_utils.toBbox(one["amodal_segmentation"]).tolist()
        hidden = sum(one["occluded_by"].values())
        assert one["amodal_area"] - one["area"] == hidden


def test_images_lead_to_the_pictures(dataset, coco, view):
    for image in coco.imgs.values():
        picture = cv2.imread(str(dataset.folder / image["file_name"]))
        assert picture.shape == (image["height"], image["width"], 3)
        frame = sequence_of(dataset, image).frame(image["frame_index"])
        np.testing.assert_array_equal(picture, frame.pictures[view])
        assert image["timestamp_s"] == frame.time_s


def test_keypoints_are_as_coco_has_them(dataset, coco, view):
    for one in coco.anns.values():
        if one["track_id"] > PERSON:
            assert "keypoints" not in one
            continue
        image = coco.imgs[one["image_id"]]
        sequence, index = sequence_of(dataset, image), image["frame_index"]
        triples = np.reshape(one["keypoints"], (-1, 3))
        category = coco.cats[one["category_id"]]
        assert len(triples) == len(category["keypoints"]) == len(one["keypoints_3d_m"])
        camera = CAMERAS[view]
        if category["name"] == "head":
            row = sequence.truth.iloc[3 * index]
            columns = f"keypoint_status_{camera}", f"keypoints_{camera}_px", "keypoints_m"
        else:
            row = sequence.skeletons.iloc[3 * index + ORDER.index(category["name"])]
            assert (row["frame_index"], row["skeleton"]) == (index, category["name"])
            columns = f"point_status_{camera}", f"points_{camera}_px", "points_m"
        status, pixels, places = (list(row[column]) for column in columns)
        assert not triples[len(status) :].any()  # knees and ankles
        triples = triples[: len(status)]
        np.testing.assert_array_equal(triples[:, 2], status)
        known = triples[:, 2] > 0
        assert one["num_keypoints"] == known.sum()
        assert not triples[~known].any()
        wanted = np.array([list(p) for p in pixels], float)
        np.testing.assert_allclose(triples[known, :2], wanted[known], atol=6e-4)
        named = one["keypoints_3d_m"][: len(places)]
        np.testing.assert_allclose(named, np.array([list(p) for p in places]), atol=6e-7)


def test_categories_have_the_skeletons_of_the_field(coco):
    """COCO's own person: 17 keypoints in its order, 19 bones; a hand: 21 joints, 20 bones."""
    person = coco.cats[PERSON]
    assert (person["name"], len(person["keypoints"]), len(person["skeleton"])) == ("person", 17, 19)
    assert person["keypoints"][:3] == ["nose", "left_eye", "right_eye"]
    assert person["keypoints"][15:] == ["left_ankle", "right_ankle"]
    for number in HANDS:
        hand = coco.cats[number]
        assert (len(hand["keypoints"]), len(hand["skeleton"])) == (21, 20)
        names = hand["keypoints"]
        for a, b in hand["skeleton"]:  # along one finger, from the wrist
            start, end = names[a - 1], names[b - 1]
            assert start == "wrist" or start.partition("_")[0] == end.partition("_")[0]
        assert sorted(b for _, b in hand["skeleton"]) == list(range(2, 22))


def scores(coco, kind, moved_px=0.0, cats=HANDS):
    """AP of the ground truth, its boxes, masks or keypoints moved, against itself."""
    fields = {"bbox": "bbox", "segm": "segmentation", "keypoints": "keypoints"}
    chosen = [a for a in coco.anns.values() if kind != "keypoints" or a["category_id"] in cats]
    results = []
    for one in chosen:
        value = one[fields[kind]]
        if moved_px and kind == "bbox":
            value = [value[0] + moved_px, *value[1:]]
        elif moved_px and kind == "segm":
            mask = np.roll(mask_utils.decode(value), int(moved_px), axis=1)
            value = mask_utils.encode(np.asfortranarray(mask))
        elif moved_px:
            value = (np.reshape(value, (-1, 3)) + np.array([moved_px, 0, 0])).ravel().tolist()
        said = {key: one[key] for key in ("image_id", "category_id")}
        results.append({**said, fields[kind]: value, "score": 1.0})
    judge = COCOeval(coco, coco.loadRes(results), kind)
    if kind == "keypoints":
        if cats == HANDS:  # else COCO's own 17
            judge.params.kpt_oks_sigmas = np.full(21, 0.05)
        judge.params.catIds = cats
    judge.evaluate()
    judge.accumulate()
    judge.summarize()
    return judge.stats[0]


@pytest.mark.parametrize("kind", ["bbox", "segm", "keypoints"])
def test_the_ground_truth_against_itself_scores_one(coco, kind):
    assert scores(coco, kind) == pytest.approx(1.0, abs=1e-12)
    assert scores(coco, kind, moved_px=15.0) < 0.9


def test_the_person_scores_with_cocos_own_sigmas(coco):
    assert scores(coco, "keypoints", cats=[PERSON]) == pytest.approx(1.0, abs=1e-12)
    assert scores(coco, "keypoints", moved_px=15.0, cats=[PERSON]) < 0.9


def test_ids_are_unique_over_both_files_and_pairs_are_of_one_frame(files):
    both = [json.loads(path.read_text()) for path in files]
    for key in ("images", "annotations"):
        ids = [one["id"] for record in both for one in record[key]]
        assert len(ids) == len(set(ids))
        assert all(0 < number < 2**53 for number in ids)
    pairs = [{i["pair_id"]: (i["sequence"], i["frame_index"]) for i in r["images"]} for r in both]
    assert pairs[0] == pairs[1]


def test_a_sequence_has_the_same_ids_without_the_others(dataset, files, tmp_path):
    alone = type(dataset)(dataset.folder, dataset.manifest, dataset.sequences[1:2])
    for few, all_of in zip(export(alone, tmp_path), files, strict=True):
        some, every = (json.loads(path.read_text()) for path in (few, all_of))
        name = dataset.sequences[1].name
        assert some["images"] == [one for one in every["images"] if one["sequence"] == name]
        ids = {one["id"] for one in some["images"]}
        wanted = [one for one in every["annotations"] if one["image_id"] in ids]
        assert some["annotations"] == wanted


def test_objects_have_the_category_of_their_kind(coco):
    cans = [a for a in coco.anns.values() if a["category_id"] >= FIRST_OBJECT_CATEGORY]
    assert cans
    for one in cans:
        assert coco.cats[one["category_id"]]["name"] == one["name"] == "can"
        assert coco.cats[one["category_id"]]["supercategory"] == "object"


def test_every_kind_of_object_has_a_category():
    """A new kind goes to the end of OBJECT_KINDS: the numbers are in files."""
    assert sorted(OBJECT_KINDS) == sorted(KINDS)
    assert OBJECT_KINDS[:3] == ("can", "cup", "box")


def change_rows(path, change):
    """Rewrite a table, each of its rows changed."""
    table = pq.read_table(path)
    rows = table.to_pylist()
    for row in rows:
        change(row)
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), path)


def test_what_a_picture_does_not_show(dataset_copy, tmp_path):
    """A lost picture, a target without a pixel, a keypoint outside the picture, one hidden."""
    folder = dataset_copy / "seq_000000"
    (folder / "left" / "000001.png").unlink()
    path = folder / "seg_left" / "000002.png"
    seg = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    cv2.imwrite(str(path), np.where(seg == 2, 4, seg).astype(np.uint8))

    def change(row):
        if row["frame_index"] == 0:
            row["arrived_left"] = False
        if row["frame_index"] == 1 and row["target"] == "right_hand":
            row["visible_left_px"] = 0
            row |= {f"box_{part}_left_px": None for part in ("x", "y", "width", "height")}
        if row["frame_index"] == 1 and row["target"] == "head":
            row["keypoint_status_left"] = [0, 1]
            row["keypoints_left_px"] = [[None, None], [7.0, 8.0]]

    change_rows(folder / "truth.parquet", change)
    left, right = (COCO(path) for path in export(sim.dataset.open(dataset_copy), tmp_path))
    shown = [{i["file_name"]: i for i in one.imgs.values()} for one in (left, right)]
    assert "seq_000000/left/000001.png" not in shown[0]
    assert "seq_000000/right/000001.png" in shown[1]
    assert len(shown[0]) == len(shown[1]) - 1
    image = shown[0]["seq_000000/left/000002.png"]
    seen = {one["track_id"]: one for one in left.imgToAnns[image["id"]]}
    assert sorted(seen) == [1, 3, PERSON]
    assert seen[1]["keypoints"] == [0, 0, 0, 7.0, 8.0, 1]
    assert seen[1]["num_keypoints"] == 1
    (hand,) = image["hidden_targets"]
    assert hand["category_id"] == hand["track_id"] == 2
    assert mask_utils.area(hand["amodal_segmentation"]) == hand["amodal_area"] > 0
    assert "segmentation" not in hand
    assert all(not i["hidden_targets"] for i in right.imgs.values())


def test_without_pycocotools_the_extra_is_named(dataset, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pycocotools.mask", None)
    with pytest.raises(BenchError, match=r"not installed: install pjpdaf-bench\[dataset\]"):
        export(dataset, tmp_path)


def test_without_ids_of_pixels_there_are_no_masks(dataset, tmp_path):
    settings = {**dataset.manifest["settings"], "labels": ["depth"]}
    bare = type(dataset)(
        dataset.folder, {**dataset.manifest, "settings": settings}, dataset.sequences
    )
    with pytest.raises(BenchError, match=r"has no label seg"):
        export(bare, tmp_path)
