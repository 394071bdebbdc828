"""The formats by name."""

from __future__ import annotations

from collections.abc import Mapping

from sim.dataset.export import coco, middlebury, mot, parquet, webdataset, yolo
from sim.dataset.export.export import Export

EXPORTS: Mapping[str, Export] = {
    "coco": coco.export,
    "mot": mot.export,
    "webdataset": webdataset.exporter(),
    "parquet": parquet.exporter(),
    "yolo-pose": yolo.pose,
    "yolo-seg": yolo.segmentation,
    "middlebury": middlebury.export,
}
