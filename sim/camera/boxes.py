"""Boxes that hold the geoms of a model, wherever they are posed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pjpdaf.arrays import Floats
from sim.gl import load_mujoco

PIECE_M = 0.15  # a longer mesh has several boxes along its longest side: they hold it closer
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])


class GeomBoxes:
    """Boxes of each geom of a model, in the geom's own frame.

    geoms (m,): the geom of each box.
    """

    def __init__(self, model: Any) -> None:
        boxes, geoms = [], []
        for geom in range(model.ngeom):
            for low, high in _boxes(model, geom):
                boxes.append(np.where(_CORNERS, high, low))
                geoms.append(geom)
        self._corners = np.array(boxes).reshape(-1, 8, 3)
        self.geoms = np.array(geoms, dtype=int)

    def corners(self, data: Any, geoms: NDArray[np.bool_]) -> Floats:
        """Corners (n, 8, 3) of the boxes of these geoms (ngeom,) as they are posed, world."""
        which = geoms[self.geoms]
        of = self.geoms[which]
        turns = np.asarray(data.geom_xmat)[of].reshape(-1, 3, 3)
        turned = self._corners[which] @ turns.transpose(0, 2, 1)
        return np.asarray(turned + np.asarray(data.geom_xpos)[of][:, None])


def _boxes(model: Any, geom: int) -> list[tuple[Floats, Floats]]:
    """Lowest and highest corner (3,) of the boxes of a geom."""
    kinds, kind = load_mujoco().mjtGeom, model.geom_type[geom]
    if kind == int(kinds.mjGEOM_MESH):
        return _mesh_boxes(model, int(model.geom_dataid[geom]))
    if kind == int(kinds.mjGEOM_PLANE):
        x, y = model.geom_size[geom, :2]
        half = np.array([x, y, 0.0])
        return [(-half, half)]
    middle, half = np.split(np.asarray(model.geom_aabb[geom], dtype=np.float64), 2)
    return [(middle - half, middle + half)]


def _mesh_boxes(model: Any, mesh: int) -> list[tuple[Floats, Floats]]:
    """Boxes around slices of a mesh, each of whole triangles, across its longest side."""
    first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    start = model.mesh_vertadr[mesh]
    vertices = np.asarray(model.mesh_vert[start : start + model.mesh_vertnum[mesh]], np.float64)
    triangles = vertices[np.asarray(model.mesh_face[first : first + count])]
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    size = high.max(axis=0) - low.min(axis=0)
    axis = int(size.argmax())
    pieces = max(round(float(size[axis]) / PIECE_M), 1)
    at = (low[:, axis] - low[:, axis].min()) / size[axis]
    piece = np.minimum((at * pieces).astype(int), pieces - 1)
    return [
        (low[piece == p].min(axis=0), high[piece == p].max(axis=0))
        for p in range(pieces)
        if (piece == p).any()
    ]
