"""The formats by name."""

from __future__ import annotations

from collections.abc import Mapping

from sim.dataset.export import coco, hdf5, middlebury, mot, parquet, webdataset, yolo
from sim.dataset.export.export import Export

EXPORTS: Mapping[str, Export] = {
    export.name: export
    for export in (
        coco.export,
        mot.export,
        webdataset.exporter(),
        parquet.exporter(),
        yolo.pose,
        yolo.segmentation,
        middlebury.export,
        hdf5.export,
    )
}
