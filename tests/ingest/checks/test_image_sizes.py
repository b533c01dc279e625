"""Single images of another size, and images too large to decode."""

import struct
import zlib

import cv2
import numpy as np
import pytest

from tactiledata.contract.image_bytes import MAX_DECODED_PIXELS, decode_rgb, read_header
from tactiledata.contract.picture_kinds import remarks_on
from tactiledata.contract.take import FrameFlag, findings_of
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.backgrounds import size_findings
from tactiledata.ingest.pipeline import ingest
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.store.check.payloads import _size_fault
from tactiledata.store.read.reader import Store


def test_check_reports_what_a_store_never_decodes():
    """Rows whose table says more pixels than the limit are a fault; one at the limit is none."""
    assert "16.8 million" in _size_fault(b"x", 4096, 4097)
    assert not _size_fault(b"x", 4096, 4096)
    assert not _size_fault(None, 30_000, 30_000)


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def bomb(side=30_000):
    """A PNG that says side x side, of a few bytes."""
    head = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


def test_too_large_picture_is_never_decoded(tmp_path, monkeypatch):
    """A picture beyond the limit is refused by its header; ingest names it and keeps its moment."""
    (tmp_path / "a.png").write_bytes(bomb())
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("decoded"))
    with pytest.raises(BrokenLog, match=r"900\.0 million pixels"):
        decode_rgb(bomb())
    report = ingest([tmp_path], tmp_path / "ds.zarr")
    assert [f.severity for f in report.sources[0].findings if f.code == "image-too-large"] == ["damage"]
    assert MAX_DECODED_PIXELS == 4096 * 4096


@pytest.mark.parametrize(("strays", "marked"), [(1, [0]), (0, []), (8, [])])
def test_stray_size_is_named_marked_and_left_out(tmp_path, strays, marked):
    """One image of 20 of another size is flagged and left out; with none or eight of them nothing is flagged."""
    folder = tmp_path / "run"
    folder.mkdir()
    rng = np.random.default_rng(0)
    for number in range(20):
        size = (64, 48, 3) if number < strays else (32, 24, 3)
        cv2.imwrite(str(folder / f"{number}.png"), rng.integers(0, 255, size, np.uint8))
    ingest([folder], tmp_path / "ds.zarr")
    store = Store.open(tmp_path / "ds.zarr")
    flags = store.frames(["flags"])["flags"].to_numpy()
    assert np.flatnonzero(flags & FrameFlag.STRAY_SIZE).tolist() == marked
    said = {finding.code: finding.message for finding in findings_of(store.findings())}
    assert ("image-stray-size" in said, "image-sizes-mixed" in said) == (strays == 1, strays == 8)
    if strays == 1:
        assert "1 of 20 images is 64 x 48" in said["image-stray-size"]
        assert "the other 19 are 32 x 24: frame 0 of trajectory 'run'" in said["image-stray-size"]
    if strays < 8:
        arrays = TactileArrays(tmp_path / "ds.zarr", "all", ("tactile",), allow_leaks=True)
        assert len(arrays) == 20 - strays


@pytest.mark.parametrize(
    ("shape", "dtype", "value", "codes"),
    [
        ((8, 8, 3), np.uint8, 200, []),
        ((8, 8, 3), np.uint16, 40_000, ["image-depth"]),
        ((8, 8, 3), np.uint16, 4_095, ["image-encoding"]),
        ((8, 8), np.uint16, 40_000, ["image-encoding"]),
        ((8, 8), np.uint8, 200, ["greyscale-image"]),
        ((8, 8, 4), np.uint8, 200, ["image-alpha"]),
    ],
)
def test_what_is_said_of_a_kind_of_picture(shape, dtype, value, codes):
    """Depth, grey and alpha are each named; 16-bit grey and dark 16-bit colours are refused; 8-bit RGB says nothing."""
    payload = cv2.imencode(".png", np.full(shape, value, dtype))[1].tobytes()
    assert [remark.code for remark in remarks_on(read_header(payload), payload)] == codes


def test_transparent_colours_are_alpha():
    """A PNG that lists one colour as transparent (tRNS) has no alpha channel, and is named like one that has."""
    plain = cv2.imencode(".png", np.full((8, 8, 3), 200, np.uint8))[1].tobytes()
    place = plain.index(b"IDAT") - 4
    listed = plain[:place] + chunk(b"tRNS", struct.pack(">HHH", 200, 200, 200)) + plain[place:]
    assert [remark.code for remark in remarks_on(read_header(plain), plain)] == []
    assert [remark.code for remark in remarks_on(read_header(listed), listed)] == ["image-alpha"]
    np.testing.assert_array_equal(decode_rgb(listed), decode_rgb(plain))


@pytest.mark.parametrize(("channels", "bits", "words"), [(4, 8, "four inks"), (3, 12, "12 bits"), (3, 8, "")])
def test_jpeg_that_is_no_rgb_is_refused(channels, bits, words):
    """A JPEG of four inks or of 12 bits is refused with that reason; the same header of 8-bit colour is not."""
    plain = cv2.imencode(".jpg", np.full((8, 8, 3), 200, np.uint8))[1].tobytes()
    place = plain.index(b"\xff\xc0")
    payload = (
        plain[: place + 4] + bytes([bits]) + plain[place + 5 : place + 9] + bytes([channels]) + plain[place + 10 :]
    )
    remarks = remarks_on(read_header(payload), payload)
    assert [remark.is_lost for remark in remarks] == ([True] if words else [])
    assert all(words in remark.words for remark in remarks)


@pytest.mark.parametrize(
    ("counts", "said"),
    [
        ({(32, 24): 39, (64, 48): 1}, ""),
        ({(64, 48): 40}, "the background of sensor D1 is 32 x 24 (rows x columns); 40 of 40 images are 64 x 48"),
        (
            {(32, 24): 20, (64, 48): 20},
            "the background of sensor D1 is 32 x 24 (rows x columns); 20 of 40 images are 64 x 48",
        ),
    ],
)
def test_a_background_is_held_against_the_sizes_of_its_images(counts, said):
    """Both sizes are named, rows first, with how many images differ; a single stray image is no fault of it."""
    findings = size_findings({"D1": np.zeros((32, 24, 3), np.uint8)}, {"D1": counts})
    assert [finding.message for finding in findings] == ([said] if said else [])
    assert all((finding.code, finding.severity) == ("background-size", "damage") for finding in findings)
