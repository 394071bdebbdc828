"""A data set for PyTorch that needs nothing of this project: both views, masks, boxes, positions.

    pip install torch opencv-python-headless pandas pyarrow
    python torch_dataset.py DATASET

Batches are of pictures of one size; DATASET needs the label `seg`.
"""

import sys
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import torch
from torch.utils.data import DataLoader, Dataset

BOX = ["box_x_left_px", "box_y_left_px", "box_width_left_px", "box_height_left_px"]


class StereoFrames(Dataset):
    """One item a stereo frame; frames of which a picture was lost are left out."""

    def __init__(self, folder):
        self.frames = []  # folder of the sequence, its three rows of truth
        for path in sorted(Path(folder).glob("seq_*/truth.parquet")):
            rows = pd.read_parquet(path)
            both = rows[rows.arrived_left & rows.arrived_right]
            self.frames += [(path.parent, frame) for _, frame in both.groupby("frame_index")]

    def __len__(self):
        return len(self.frames)

    def __getitem__(self, i):
        where, rows = self.frames[i]
        file = f"{rows.frame_index.iloc[0] + 1:06d}.png"  # files count from 1
        views = np.stack([cv2.imread(str(where / view / file)) for view in ("left", "right")])
        return {
            "views": torch.from_numpy(views[..., ::-1].copy()).permute(0, 3, 1, 2) / 255,  # RGB
            "seg": torch.from_numpy(cv2.imread(str(where / "seg_left" / file), -1)),  # rig.json
            "boxes_px": torch.tensor(rows[BOX].to_numpy(np.float32)),  # NaN where nothing shows
            "positions_m": torch.tensor(rows[["x_m", "y_m", "z_m"]].to_numpy(np.float32)),
        }


if __name__ == "__main__":
    batch = next(iter(DataLoader(StereoFrames(sys.argv[1]), batch_size=4, shuffle=True)))
    for name, values in batch.items():
        print(name, tuple(values.shape), values.dtype)
