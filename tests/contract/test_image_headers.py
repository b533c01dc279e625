"""Headers written byte by byte: what each kind of PNG and JPEG says of itself, and where reading ends."""

import struct
import zlib

import pytest

from tactiledata.contract.image_bytes import decode_rgb, read_header, size_fault
from tactiledata.errors import BrokenLog

START, END = b"\xff\xd8", b"\xff\xd9"


def chunk(kind, content=b""):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png(height=3, width=5, bits=8, colour=2, *chunks):
    header = struct.pack(">IIBB", width, height, bits, colour) + b"\0\0\0"
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + b"".join(chunks) + chunk(b"IEND")


def segment(mark, content):
    return bytes([0xFF, mark]) + struct.pack(">H", len(content) + 2) + content


def frame(mark=0xC0, height=3, width=5, bits=8, channels=3):
    return segment(mark, struct.pack(">BHHB", bits, height, width, channels))


def facts(payload):
    header = read_header(payload)
    return header.height, header.width, header.channels, header.bits, header.has_alpha, header.is_complete


@pytest.mark.parametrize(
    ("colour", "bits", "channels", "said_bits", "has_alpha"),
    [(0, 16, 1, 16, False), (0, 1, 1, 1, False), (2, 8, 3, 8, False), (3, 4, 3, 8, False), (4, 8, 2, 8, True),
     (6, 16, 4, 16, True)],
)  # fmt: skip
def test_colour_types_of_png(colour, bits, channels, said_bits, has_alpha):
    """PNG (third edition), table 12: grey, colours, palette (whose colours have 8 bits), and both with alpha."""
    assert facts(png(3, 5, bits, colour)) == (3, 5, channels, said_bits, has_alpha, True)


@pytest.mark.parametrize("cut", range(16 + 1))
def test_a_png_cut_within_its_last_chunks_is_incomplete(cut):
    """Cut in the end mark or in the CRC-32 before it, the chunk that is torn is an end that is missing, not damage."""
    payload = png(3, 5, 8, 2, chunk(b"IDAT", b"content"))
    assert read_header(payload[: len(payload) - cut]).is_complete == (cut == 0)


@pytest.mark.parametrize("colour", [1, 5, 7])
def test_other_colour_types_are_refused(colour):
    """The numbers between have no meaning."""
    with pytest.raises(BrokenLog, match=f"a PNG with colour type {colour}"):
        read_header(png(colour=colour))


@pytest.mark.parametrize("colour", [0, 2, 3])
def test_a_list_of_transparent_colours_is_alpha(colour):
    """The chunk tRNS states transparency wherever it stands, of grey, colours and palettes."""
    assert read_header(png(3, 5, 8, colour, chunk(b"tRNS", b"ab"))).has_alpha
    assert read_header(png(3, 5, 8, colour, chunk(b"gAMA", b"1234"), chunk(b"tRNS", b"ab"), chunk(b"IDAT"))).has_alpha
    assert not read_header(png(3, 5, 8, colour, chunk(b"gAMA", b"tRNS"))).has_alpha
    # behind the end it is no part of the picture
    assert not read_header(png(3, 5, 8, colour) + chunk(b"tRNS", b"ab")).has_alpha


def test_a_png_begins_with_its_header():
    """Another chunk in its place is refused, however long the file is; the message says how long."""
    for other in (b"iHDR", b"CgBI", b"IHDQ"):
        payload = png().replace(b"IHDR", other)
        with pytest.raises(BrokenLog, match=f"a PNG of {len(payload)} bytes that ends before"):
            read_header(payload)


@pytest.mark.parametrize("encode", [png, lambda height, width: START + frame(0xC0, height, width) + END])
def test_sides_reach_from_1_to_32767(encode):
    """Heights and widths are kept as 16-bit integers; 0 and 32768 are refused, with the size in the message."""
    assert facts(encode(32767, 1))[:2] == (32767, 1)
    assert facts(encode(1, 32767))[:2] == (1, 32767)
    for height, width in ((32768, 1), (1, 32768), (0, 1), (1, 0)):
        with pytest.raises(BrokenLog, match=f"image of {height} rows x {width} columns") as caught:
            read_header(encode(height, width))
        assert "at most 32767 pixels a side" in str(caught.value)


@pytest.mark.parametrize("mark", range(0xC0, 0xD0))
def test_frame_headers_of_jpeg(mark):
    """ITU-T T.81, table B.1: C0 to CF begin a frame, but for the tables C4 and CC and the reserved C8."""
    payload = START + frame(mark) + END
    if mark in (0xC4, 0xC8, 0xCC):
        with pytest.raises(BrokenLog, match=f"a JPEG of {len(payload)} bytes that ends or breaks"):
            read_header(payload)
    else:
        assert facts(payload) == (3, 5, 3, 8, False, True)


@pytest.mark.parametrize("mark", [0xBF, 0xD8, 0xDB, 0xE1, 0xFE])
def test_other_segments_are_passed_over_by_their_length(mark):
    """What looks like a frame inside of them is none; the frame behind them counts."""
    inner = segment(mark, b"ab" + frame(0xC0, 99, 99) + END)
    assert facts(START + inner + frame() + END)[:2] == (3, 5)


@pytest.mark.parametrize("mark", [0x01, *range(0xD0, 0xD8)])
def test_marks_that_stand_alone(mark):
    """Marks without a length are passed over: eight restarts and one more, even twice in a row."""
    alone = bytes([0xFF, mark])
    assert facts(START + alone + alone + frame() + END)[:2] == (3, 5)


def test_channels_and_bits_of_jpeg():
    """Four inks, one grey, and twelve bits; a JPEG has no transparency."""
    assert facts(START + frame(channels=4) + END) == (3, 5, 4, 8, False, True)
    assert facts(START + frame(channels=1, bits=12) + END) == (3, 5, 1, 12, False, True)


@pytest.mark.parametrize("end", [0xDA, 0xD9])
def test_nothing_behind_a_scan_or_the_end_is_a_frame(end):
    """The scan's bytes are pixels, and behind the end mark is another picture."""
    with pytest.raises(BrokenLog, match="before its size is stated"):
        read_header(START + segment(end, b"ab") + frame() + END)
    assert facts(START + frame() + segment(end, b"ab") + frame(0xC0, 99, 99) + END)[:2] == (3, 5)


def test_bytes_between_segments_end_the_reading():
    """A JPEG ends where a marker is due and another byte stands: a size before that place counts, one after it not."""
    with pytest.raises(BrokenLog, match="before its size is stated"):
        read_header(START + b"\0" + frame() + END)
    assert facts(START + frame() + b"\0\0" + frame(0xC0, 99, 99) + END)[:2] == (3, 5)


def test_the_end_mark_counts_outside_of_segments_alone():
    """The last four bytes are a segment that says it is 65,497 bytes long, not an end mark."""
    assert not read_header(START + frame() + b"\xff\xe1\xff\xd9").is_complete
    assert read_header(START + frame() + b"\xff\xe1\0\x02" + END).is_complete


def test_a_frame_header_needs_its_ten_bytes():
    """Mark, length, bits, size and channels are ten bytes: one less states no size."""
    assert facts(START + frame()) == (3, 5, 3, 8, False, False)
    with pytest.raises(BrokenLog, match="a JPEG of 11 bytes"):
        read_header((START + frame())[:-1])


@pytest.mark.parametrize(
    ("pixels", "millions"), [(17_050_000, "17.1"), (17_049_990, "17.0"), (16_777_217, "16.8"), (100_000_000, "100.0")]
)
def test_millions_are_rounded_to_a_tenth(pixels, millions):
    """17.05 million are said as 17.1, ten pixels fewer as 17.0."""
    assert f"are {millions} million pixels, and at most 16.8 million" in size_fault(1, pixels)


@pytest.mark.parametrize("payload", [png(4097, 4096), START + frame(0xC0, 4097, 4096) + END])
def test_a_picture_beyond_the_limit_is_not_decoded(payload):
    """A picture beyond the limit is refused by its header alone; one of the largest size fails as undecodable."""
    with pytest.raises(BrokenLog, match=r"at most 16777216 pixels.*Crop it to the gel"):
        decode_rgb(payload)
    with pytest.raises(BrokenLog, match="image of 3 x 5 that does not decode"):
        decode_rgb(png())
