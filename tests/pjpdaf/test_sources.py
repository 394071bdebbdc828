"""Footage: order, pairing, faults that name the file, flat memory."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

from pjpdaf.errors import BenchError
from pjpdaf.pairing import natural_key, paired
from pjpdaf.picture_files import is_grey, read_picture, stored_fault
from pjpdaf.sources import PictureFolder, open_source, picture_pairs, stereo_frames
from pjpdaf.videos import Video

SIZE = (64, 48)


def shade(value: int, size: tuple[int, int] = SIZE) -> np.ndarray:
    return np.full((size[1], size[0], 3), value, np.uint8)


def write(folder: Path, names: list[str], first: int = 0) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    for i, name in enumerate(names):
        assert cv2.imwrite(str(folder / name), shade(first + 10 * i))
    return folder


def write_video(path: Path, count: int, rate_hz: float = 5.0) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), rate_hz, SIZE)
    assert writer.isOpened()
    for i in range(count):
        writer.write(shade(10 * i))
    writer.release()
    return path


def numbered(count: int, stem: str = "f", suffix: str = ".png") -> list[str]:
    return [f"{stem}{i}{suffix}" for i in range(count)]


def values(frames, view: int = 0) -> list[int | None]:
    return [None if f.pictures[view] is None else int(f.pictures[view][0, 0, 0]) for f in frames]


@pytest.fixture
def folders(tmp_path) -> tuple[Path, Path]:
    return write(tmp_path / "left", numbered(12)), write(tmp_path / "right", numbered(12), 1)


def test_natural_order():
    names = ["f10.png", "f2.png", "F1.png", "a.png", "f2b.png", "10.png", "9.png"]
    assert sorted(names, key=natural_key) == [
        "9.png",
        "10.png",
        "a.png",
        "F1.png",
        "f2.png",
        "f2b.png",
        "f10.png",
    ]


def test_folders_give_frames_in_natural_order_at_the_thesis_rate(folders):
    frames = list(stereo_frames(*folders))
    assert values(frames) == [10 * i for i in range(12)]
    assert values(frames, 1) == [10 * i + 1 for i in range(12)]
    assert [f.index for f in frames] == list(range(12))
    assert frames[3].time_s == pytest.approx(1.0)
    assert frames[0].pictures[0].shape == (48, 64, 3)
    assert frames[0].pictures[0].dtype == np.uint8
    assert next(stereo_frames(*folders, rate_hz=10)).time_s == 0


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".BMP", ".tif", ".jpeg"])
def test_picture_kinds(tmp_path, suffix):
    left = write(tmp_path / "l", numbered(2, suffix=suffix))
    (left / "notes.txt").write_text("not a picture")
    (left / ".hidden.png").write_bytes(b"")
    assert open_source(left).count == 2
    assert values(stereo_frames(left, left)) == [0, 10]


def test_both_views_in_one_folder_by_patterns(tmp_path):
    write(tmp_path / "both", numbered(3, "left"))
    write(tmp_path / "both", numbered(3, "right"), 5)
    frames = list(stereo_frames(tmp_path / "both" / "left*.png", tmp_path / "both/right*"))
    assert values(frames, 1) == [5, 15, 25]
    with pytest.raises(BenchError, match="no pictures match this pattern"):
        open_source(tmp_path / "both" / "middle*.png")


def test_a_corrupt_picture_is_named_and_missing(folders, capfd):
    left, right = folders
    whole = (left / "f3.png").read_bytes()
    (left / "f3.png").write_bytes(whole[: len(whole) // 2])
    (right / "f5.png").write_bytes(b"")
    (right / "f6.png").write_text("not a picture")
    messages: list[str] = []
    frames = list(stereo_frames(left, right, warn=messages.append))
    assert values(frames)[3] is None
    assert values(frames, 1)[3] == 31
    assert values(frames, 1)[5:7] == [None, None]
    assert len(frames) == 12
    assert len(messages) == 3
    for line, name in zip(messages, ("left/f3.png", "right/f5.png", "right/f6.png"), strict=True):
        assert f"{name}: cannot be read as a picture" in line.replace("\\", "/")
    assert "grfmt" not in capfd.readouterr().err


def test_a_missing_picture_is_named_and_its_partner_kept(folders):
    left, right = folders
    (right / "f4.png").unlink()
    messages: list[str] = []
    frames = list(stereo_frames(left, right, warn=messages.append))
    assert len(frames) == 12
    assert values(frames, 1)[3:6] == [31, None, 51]
    assert values(frames)[4] == 40
    assert len(messages) == 1
    assert messages[0].startswith("right: no picture belongs to ")
    assert "f4.png" in messages[0]


def test_counts_that_differ_without_common_numbers(tmp_path):
    left = write(tmp_path / "l", ["a.png", "b.png", "c.png"])
    right = write(tmp_path / "r", ["x.png", "y.png"])
    with pytest.raises(BenchError, match=r"l has 3 pictures, \S+r 2;") as fault:
        stereo_frames(left, right)  # before the first frame
    assert "\n" not in str(fault.value)
    assert len(list(stereo_frames(left, right, shortest=True))) == 2


def test_other_numberings_are_paired_in_order(tmp_path):
    left = write(tmp_path / "l", ["f7.png", "f8.png"])
    right = write(tmp_path / "r", ["f100.png", "f101.png"], 1)
    assert values(stereo_frames(left, right), 1) == [1, 11]
    write(tmp_path / "r", ["f102.png"])
    with pytest.raises(BenchError, match="differ in length"):
        stereo_frames(left, right)


def test_a_constant_last_number_is_not_a_frame_number(tmp_path):
    left = write(tmp_path / "l", [f"{i}_cam1.png" for i in range(3)])
    right = write(tmp_path / "r", [f"{i}_cam2.png" for i in range(3)], 1)
    assert values(stereo_frames(left, right), 1) == [1, 11, 21]


def test_a_wrong_size_names_file_and_sizes(folders):
    left, right = folders
    cv2.imwrite(str(right / "f2.png"), shade(0, (32, 24)))
    with pytest.raises(BenchError, match=r"f2\.png: the picture is 32x24 px, expected 64x48, that"):
        list(stereo_frames(left, right))
    with pytest.raises(BenchError, match=r"f0\.png: .* 64x48 px, expected 640x480, the calibrat"):
        next(stereo_frames(left, right, sizes_px=((640, 480), (640, 480))))


def test_frames_are_read_one_at_a_time(folders, monkeypatch):
    reads: list[str] = []

    def read(file: Path) -> np.ndarray | None:
        reads.append(file.name)
        return read_picture(file)

    monkeypatch.setattr("pjpdaf.sources.read_picture", read)
    frames = stereo_frames(*folders)
    assert reads == []
    next(frames)
    next(frames)
    assert reads == ["f0.png", "f0.png", "f1.png", "f1.png"]


def test_videos(tmp_path):
    left, right = write_video(tmp_path / "l.avi", 8), write_video(tmp_path / "r.avi", 8)
    source = open_source(left)
    assert isinstance(source, Video)
    assert (source.count, source.rate_hz) == (8, 5.0)
    frames = list(stereo_frames(left, right))
    assert len(frames) == 8
    assert frames[5].time_s == pytest.approx(1.0)
    # JPEG: within a few grey levels.
    np.testing.assert_allclose(values(frames), [10 * i for i in range(8)], atol=3)
    assert next(iter(picture_pairs(left, right))).names[0].endswith("l.avi frame 0")


def test_videos_that_differ(tmp_path):
    left, right = write_video(tmp_path / "l.avi", 8), write_video(tmp_path / "r.avi", 6)
    with pytest.raises(BenchError, match=r"l\.avi has 8 frames, \S+r\.avi 6"):
        stereo_frames(left, right)
    messages: list[str] = []
    assert len(list(stereo_frames(left, right, warn=messages.append, shortest=True))) == 6
    assert len(messages) == 1
    assert "r.avi: ends after 6 of 6 frames; both views stop here." in messages[0]
    fast = write_video(tmp_path / "fast.avi", 8, 10.0)
    with pytest.raises(BenchError, match=r"frame rates differ: \S+l\.avi 5/s, \S+fast\.avi 10/s"):
        stereo_frames(left, fast)


def test_a_video_cut_short_gives_what_it_has(tmp_path):
    whole = write_video(tmp_path / "l.avi", 24)
    cut = tmp_path / "cut.avi"
    data = whole.read_bytes()
    cut.write_bytes(data[: len(data) * 2 // 3])
    frames = list(stereo_frames(cut, cut))
    assert 0 < len(frames) < 24


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: p / "none", "no such file or folder"),
        (lambda p: write(p / "empty", []), "no pictures in this folder"),
        (lambda p: write(p / "one", ["a.png"]) / "a.png", "one picture is not a sequence"),
    ],
)
def test_a_source_that_is_none(tmp_path, make, words):
    path = make(tmp_path)
    with pytest.raises(BenchError, match=words) as fault:
        stereo_frames(path, path)
    assert str(path) in str(fault.value)


def test_text_is_no_video(tmp_path):
    (tmp_path / "film.mp4").write_text("no film")
    with pytest.raises(BenchError, match=r"film\.mp4: not a video that can be read here"):
        open_source(tmp_path / "film.mp4")


def test_a_folder_and_a_video_do_not_pair(tmp_path):
    video = write_video(tmp_path / "l.avi", 3)
    folder = write(tmp_path / "r", numbered(3))
    with pytest.raises(BenchError, match="must be of one kind"):
        stereo_frames(folder, video)


def test_a_bad_rate_is_refused(folders):
    with pytest.raises(BenchError, match="frame rate must be above 0 Hz, got -1"):
        stereo_frames(*folders, rate_hz=-1)


def test_names_with_spaces_and_umlauts(tmp_path):
    left = write(tmp_path / "linke Bilder", ["a 1.png"])
    (left / "a 1.png").rename(left / "Grüße 1.png")
    source = open_source(left)
    assert isinstance(source, PictureFolder)
    assert read_picture(source.files[0]) is not None


CLOCK = [f"cap_{t}.png" for t in ("10-59-57", "10-59-58", "10-59-59", "11-00-00", "11-00-01")]
DECIMAL = [f"{1305031102.175304 + k * 0.333:.6f}.png" for k in range(6)]
STAMPS = ["2026-01-31_9.png", "2026-01-31_10.png", "2026-02-01_1.png", "2026-12-01_2.png"]


@pytest.mark.parametrize("names", [CLOCK, DECIMAL, STAMPS], ids=["clock", "decimal", "dates"])
def test_pictures_named_by_a_time_come_in_its_order(tmp_path, names):
    left, right = write(tmp_path / "l", names), write(tmp_path / "r", names, 1)
    messages: list[str] = []
    frames = list(stereo_frames(left, right, warn=messages.append))
    assert values(frames) == [10 * k for k in range(len(names))]
    assert values(frames, 1) == [10 * k + 1 for k in range(len(names))]
    assert messages == []


def test_pairs_by_the_whole_name(tmp_path):
    takes = [f"take{t}_left_{k:03d}.png" for t in (1, 2) for k in (7, 8)]
    left = write(tmp_path / "l", takes)
    right = write(tmp_path / "r", [name.replace("left", "right") for name in takes[1:]], 11)
    messages: list[str] = []
    frames = list(stereo_frames(left, right, warn=messages.append))
    assert values(frames) == [0, 10, 20, 30]
    assert values(frames, 1) == [None, 11, 21, 31]
    assert len(messages) == 1
    assert "take1_left_007.png" in messages[0]


def test_names_that_leave_a_doubt_are_said(tmp_path):
    names = ["0.5.png", "0.25.png", "0.75.png"]
    assert (
        "0.5.png is taken to come before 0.25.png"
        in paired(*[[Path(n) for n in sorted(names, key=natural_key)]] * 2).note
    )
    left, right = (
        write(tmp_path / "l", ["a7.png", "a8.png"]),
        write(tmp_path / "r", ["b1.png", "b2.png"]),
    )
    messages: list[str] = []
    assert len(list(picture_pairs(left, right, messages.append))) == 2
    (line,) = messages
    assert "do not belong together (a7.png, b1.png ...): they are paired in order" in line


def write_times(path: Path, times_ms: list[int], size=SIZE) -> Path:
    """A video whose frames have these times, in a container that says 30/s."""
    av = pytest.importorskip("av")
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 1000)
        for k, time_ms in enumerate(times_ms):
            frame = av.VideoFrame.from_ndarray(shade(10 * k, size), format="bgr24")
            frame.pts, frame.time_base = time_ms, Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def test_a_variable_frame_rate_gives_each_frame_its_own_time(tmp_path):
    times_ms = [0, 100, 400, 500, 900, 1000, 1400, 1500, 2100]
    left, right = (write_times(tmp_path / f"{v}.mkv", times_ms) for v in "lr")
    frames = list(stereo_frames(left, right))
    assert [f.time_s for f in frames] == pytest.approx([t / 1000 for t in times_ms], abs=2e-3)
    assert [f.time_s for f in stereo_frames(left, right, 10.0)][:3] == [0.0, 0.1, 0.2]
    late = write_times(tmp_path / "late.mkv", [0, 100, 200, 300, 400, 500, 600, 700, 800])
    messages: list[str] = []
    frames = list(stereo_frames(left, right, warn=messages.append))
    assert messages == []
    assert len(list(stereo_frames(left, late, warn=messages.append, shortest=True))) == 9
    assert "frame 2: is at 0.400 s, the right view's at 0.200 s" in messages[0]


@pytest.mark.parametrize("layout", ["side-by-side", "top-bottom"])
def test_both_views_in_one_picture(tmp_path, layout):
    axis = 1 if layout == "side-by-side" else 0
    for k in range(3):
        both = np.concatenate([shade(10 * k), shade(10 * k + 5)], axis=axis)
        (tmp_path / "both").mkdir(exist_ok=True)
        cv2.imwrite(str(tmp_path / "both" / f"{k}.png"), both)
    frames = list(stereo_frames(tmp_path / "both", None, layout=layout))
    assert (values(frames), values(frames, 1)) == ([0, 10, 20], [5, 15, 25])
    assert frames[0].pictures[1].shape == (48, 64, 3)
    with pytest.raises(BenchError, match=f"--stereo {layout}: both views are in .*leave --right"):
        picture_pairs(tmp_path / "both", tmp_path / "both", layout=layout)
    with pytest.raises(BenchError, match="is one view; give --right, or --stereo side-by-side"):
        picture_pairs(tmp_path / "both", None)
    film = write_times(tmp_path / "both.mkv", [0, 40, 130], (128, 48))
    halves = list(stereo_frames(film, None, layout="side-by-side"))
    assert [f.time_s for f in halves] == pytest.approx([0, 0.04, 0.13], abs=2e-3)


def test_the_rest_of_a_longer_view_is_left_out_where_asked(tmp_path):
    left, right = (
        write(tmp_path / "l", ["a.png", "b.png", "c.png"]),
        write(tmp_path / "r", ["x.png"]),
    )
    with pytest.raises(BenchError, match="--shortest leaves out the rest of the longer one"):
        picture_pairs(left, right)


def test_pictures_in_which_no_skin_can_be_found_are_named(tmp_path):
    rng = np.random.default_rng(0)
    colour = rng.integers(20, 230, (48, 64, 3)).astype(np.uint8)
    ten, full = colour.astype(np.uint16) * 4, colour.astype(np.uint16) * 256
    for name, picture in (("ten", ten), ("full", full), ("colour", colour)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), picture)
    fault = stored_fault(tmp_path / "ten.png")
    assert fault.endswith(
        "ten.png: is a picture of 16 bits whose values use 10: nearly black. Convert the pictures "
        "to 8 bits, all values divided by 4"
    )
    assert stored_fault(tmp_path / "full.png") == stored_fault(tmp_path / "colour.png") == ""
    assert is_grey([np.repeat(colour[..., :1], 3, axis=2)])
    assert not is_grey([colour])


def test_a_picture_is_turned_upright_as_a_video_is(tmp_path):
    """EXIF orientation 6: the sensor lay on its side."""
    file = tmp_path / "turned.jpg"
    stored = shade(40)
    stored[:, :8] = 200  # left edge as stored, top edge upright
    cv2.imwrite(str(file), stored)
    data = file.read_bytes()
    exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"
    file.write_bytes(data[:2] + b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif + data[2:])
    picture = read_picture(file)
    assert picture.shape == (64, 48, 3)
    assert picture[4].mean() > 150 > 100 > picture[40].mean()
