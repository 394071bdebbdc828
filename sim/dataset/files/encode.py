"""Labels as files, and back: PNG of 8 and 16 bits, NPZ of float32."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pjpdaf.errors import FileError
from sim.dataset.files.layout import DEPTH_UNIT_M, DISPARITY_SCALE, FLOW_SCALE, FLOW_ZERO
from sim.dataset.labels.records import NO_SURFACE, Matches

_PNG = b"\x89PNG\r\n\x1a\n"
# Raised by the libraries for a file that is no NPZ, cut short, locked or packed in another way.
_NPZ_FAULTS = (
    ValueError,
    EOFError,
    NotImplementedError,
    RuntimeError,
    zipfile.BadZipFile,
    zlib.error,
)
FLOATS = ("depth_m", "disparity_px", "places_px")  # arrays of the label `float`
MOST_PX = 64 << 20  # pixels of a picture that is read; a PNG of a few kB can hold far more


def png(picture: NDArray[Any]) -> bytes:
    """A picture (h, w) or (h, w, 3) of 8 or 16 bits as PNG, lossless."""
    done, data = cv2.imencode(".png", picture)
    assert done, "OpenCV always encodes such a picture"
    return bytes(data)


def read_png(path: Path, dtype: type, channels: int) -> NDArray[Any]:
    """The picture of a PNG file (h, w) or (h, w, channels).

    Raises FileError where it is missing, damaged, or of another kind.
    """
    try:
        data = path.read_bytes()
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror}") from fault
    if data[:8] != _PNG or data[12:16] != b"IHDR":
        raise FileError(path, "is not a PNG picture, or a damaged one")
    # Width and height stand in the first chunk; a picture is not unpacked to find out.
    width, height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))
    if not 0 < width * height <= MOST_PX:
        raise FileError(
            path,
            f"says that it is {width}x{height}; more than {MOST_PX >> 20} million pixels "
            "are not read",
        )
    if not _is_whole(data):
        raise FileError(path, "is a damaged PNG picture")
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(0)  # OpenCV prints what is raised here as well
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        picture = None
    finally:
        cv2.utils.logging.setLogLevel(level)
    if picture is None:
        raise FileError(path, "is a damaged PNG picture")
    shape = picture.shape[:2] if channels == 1 else (*picture.shape[:2], channels)
    if picture.dtype != dtype or picture.shape != shape:
        raise FileError(
            path,
            f"must have {channels} channels of {np.dtype(dtype).name}, has "
            f"{1 if picture.ndim == 2 else picture.shape[2]} of {picture.dtype.name}",
        )
    return np.asarray(picture)


def _is_whole(data: bytes) -> bool:
    """Whether all chunks of a PNG are there with the right checksums: libpng prints where not."""
    view, at = memoryview(data), len(_PNG)
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(view[at : at + 4], "big")
        if zlib.crc32(view[at + 4 : end]) != int.from_bytes(view[end : end + 4], "big"):
            return False
        if data[at + 4 : at + 8] == b"IEND":
            return end + 4 <= len(data)
        at = end + 4
    return False


def depth_to_png(depth_m: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Planar z (h, w) [m], NaN for nothing, in DEPTH_UNIT_M; 0 for nothing or too far."""
    return _whole(depth_m.astype(np.float64) / DEPTH_UNIT_M)


def depth_from_png(picture: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Inverse of the encoding; NaN for 0."""
    metres = picture.astype(np.float64) * DEPTH_UNIT_M
    return np.where(picture > 0, metres, np.nan).astype(np.float32)


def disparity_to_png(disparity_px: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Disparity (h, w) [px], NaN for none, in the format of KITTI: 1/256 px, 0 for none."""
    return _whole(disparity_px.astype(np.float64) * DISPARITY_SCALE)


def disparity_from_png(picture: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Inverse of the encoding; NaN for 0."""
    return np.where(picture > 0, picture / DISPARITY_SCALE, np.nan).astype(np.float32)


def matches_to_png(matches: Matches) -> NDArray[np.uint16]:
    """`Matches.places_px` in KITTI's flow format, (h, w, 3): status, dy, dx in OpenCV's order.

    A position beyond the range of the format (512 px) is clipped to its end, which is outside the
    frame.
    """
    assert matches.places_px is not None, "only matches of the pictures as they are have places"
    height, width = matches.status.shape
    flow = np.empty((height, width, 3), np.uint16)
    flow[..., 0] = matches.status
    unknown = matches.status == NO_SURFACE
    rows, columns = np.arange(height, dtype=np.float64)[:, None], np.arange(width, dtype=np.float64)
    for channel, (axis, own) in enumerate(((1, rows), (0, columns)), start=1):
        steps = (matches.places_px[..., axis] - own) * FLOW_SCALE + FLOW_ZERO
        np.fmax(steps, 0.0, out=steps)  # 0 for NaN
        np.minimum(steps, 65535.0, out=steps)
        steps[unknown] = 0.0
        flow[..., channel] = np.rint(steps, out=steps)
    return flow


def matches_from_png(flow: NDArray[np.uint16]) -> Matches:
    """Inverse of `matches_to_png`, to 1/128 px."""
    height, width = flow.shape[:2]
    ys, xs = np.mgrid[:height, :width]
    moved = (flow[..., 2:0:-1].astype(np.float64) - FLOW_ZERO) / FLOW_SCALE
    places = moved + np.stack([xs, ys], axis=-1)
    status = flow[..., 0].astype(np.uint8)
    places[status == NO_SURFACE] = np.nan
    return Matches(status, places_px=places.astype(np.float32))


def amodal_to_png(masks: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Masks (T, h, w) as a byte per pixel, with a bit per target."""
    bits = np.zeros(masks.shape[1:], np.uint8)
    for target, mask in enumerate(masks):
        bits |= mask.astype(np.uint8) << target
    return bits


def amodal_from_png(bits: NDArray[np.uint8], targets: int) -> NDArray[np.bool_]:
    """Inverse of `amodal_to_png` (targets, h, w)."""
    return np.stack([(bits >> target) & 1 for target in range(targets)]).astype(bool)


def npz(**arrays: NDArray[Any]) -> bytes:
    """Arrays as a compressed NPZ; the same arrays, the same bytes.

    NumPy's own, of deflate's level 6, takes twice the time for 2 % fewer bytes.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as held:
        for name, array in arrays.items():
            file = io.BytesIO()
            np.lib.format.write_array(file, array, allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy")  # of no date
            held.writestr(info, file.getvalue(), zipfile.ZIP_DEFLATED, compresslevel=1)
    return buffer.getvalue()


def read_npz(path: Path, size_px: tuple[int, int]) -> dict[str, NDArray[np.float32]]:
    """Arrays of the label `float` by name; size_px: height and width that they must have.

    Raises FileError where the file is missing, damaged, or holds anything else.
    """
    arrays: dict[str, NDArray[np.float32]] = {}
    try:
        with zipfile.ZipFile(io.BytesIO(path.read_bytes())) as held:
            for entry in held.infolist():
                name = entry.filename.removesuffix(".npy")
                shape = (*size_px, 2) if name == "places_px" else size_px
                if name not in FLOATS or name in arrays:
                    raise ValueError(f"it may not hold {entry.filename[:40]!r}")
                with held.open(entry) as file:
                    # The header says how much is unpacked; it is checked before that is.
                    version = np.lib.format.read_magic(file)
                    if version != (1, 0):
                        raise ValueError(f"{name} is of another version of the format")
                    stored, _, dtype = np.lib.format.read_array_header_1_0(file)
                    if stored != shape or dtype != np.float32:
                        raise ValueError(f"{name} is {dtype} {stored}, must be float32 {shape}")
                with held.open(entry) as file:
                    arrays[name] = np.lib.format.read_array(file, allow_pickle=False)
    except OSError as fault:
        raise FileError(path, f"cannot be read: {fault.strerror or fault}") from fault
    except _NPZ_FAULTS as fault:
        raise FileError(path, f"is a damaged NPZ file: {_one_line(fault)}") from fault
    return arrays


def _one_line(fault: Exception) -> str:
    return " ".join(str(fault).split())[:200].rstrip(".")


def _whole(values: NDArray[np.float64]) -> NDArray[np.uint16]:
    known = np.isfinite(values) & (values >= 0.5) & (values <= 65535.0)
    return np.where(known, np.rint(np.where(known, values, 0.0)), 0).astype(np.uint16)
