"""What is said of the images and forces of a take, just below and just above each rule."""

import dataclasses

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Source
from tactiledata.contract.take import FrameFlag, Reference
from tactiledata.ingest.checks.background_seen import touched_findings
from tactiledata.ingest.checks.checks import FT_RANGE, broken_images, check_take, flag_images
from tactiledata.ingest.checks.plausible import mesh_findings
from tactiledata.ingest.checks.spooled import SpooledImages
from tactiledata.sensors import SENSORS
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background
from tests.ingest.checks.test_spooled import image, spooled
from tests.ingest.made_takes import frames, signal, take, told, touch

DIGIT = load_background(next(iter(bundled_backgrounds())))
BGR = np.ascontiguousarray(DIGIT[..., ::-1])


def nothing(rows):
    return [None] * len(rows)


def said(made, decode=nothing):
    return check_take(made, decode)


@pytest.mark.parametrize(("padding", "is_broken"), [(0, False), (62, False), (63, True), (64, True)])
def test_a_jpeg_ends_with_its_trailer(tmp_path, padding, is_broken):
    """Up to 62 bytes of padding may follow the two of the end of image; a PNG's end are four."""
    images = spooled(tmp_path, [image(b"x" * 100 + b"\xff\xd9" + b"\0" * padding, "jpeg")])
    rows, findings = broken_images(images)
    assert rows.tolist() == ([0] if is_broken else [])
    assert told(findings) == ([("image-truncated", "damage", "", 1)] if is_broken else [])


def test_rows_of_broken_images_are_in_order(tmp_path):
    """JPEGs and PNGs alike, each by its own trailer; raw and missing images have none."""
    whole = {"jpeg": b"\xff\xd9", "png": b"IEND\xaeB`\x82"}
    made = [
        image(b"no end", "png"), image(b"no end", "jpeg"), image(b"abc" + whole["png"], "png"), image(b"", "missing"),
        image(bytes(8 * 6 * 3), "raw"), image(whole["jpeg"], "jpeg"), image(whole["png"], "jpeg"),
    ]  # fmt: skip
    rows, [finding] = broken_images(spooled(tmp_path, made))
    assert rows.tolist() == [0, 1, 6]
    assert finding.count == 3


def test_the_flag_of_broken_images_is_set_in_the_stores_order():
    """Flags that were set before stay; nothing broken changes nothing."""
    table = frames(4, flags=[0, FrameFlag.OUTSIDE, 0, 0])
    flagged = flag_images(table, np.array([3, 1, 0, 2]), np.array([1, 2]), FrameFlag.BROKEN)
    assert flagged["flags"].to_pylist() == [0, FrameFlag.OUTSIDE | FrameFlag.BROKEN, 0, FrameFlag.BROKEN]
    assert flagged.schema == table.schema
    assert flag_images(table, np.arange(4), np.zeros(0, np.int64), FrameFlag.BROKEN) is table


def sized(sizes, model="digit", **parts):
    """Codes, and first words, of what is said of images with some sizes."""
    heights, widths = zip(*sizes, strict=True)
    made = take(frames(len(sizes), height=heights, width=widths), sensors={"D1": {"model": model}}, **parts)
    found = said(made, lambda rows: [np.zeros((8, 6, 3), np.uint8)] * len(rows))
    return [(one.code, one.severity, one.message.partition(";")[0]) for one in found]


def test_sizes_are_held_against_the_sensor_model():
    """The model's own size says nothing; it turned, and any other size, are told apart, the most frequent first."""
    rows, columns = SENSORS["digit"].camera.shape
    own, turned = (rows, columns), (columns, rows)
    assert sized([own] * 3) == []
    assert sized([turned] * 3) == [("image-swapped", "warning", f"images of 'D1' have {columns} rows x {rows} columns")]
    assert sized([own, turned, turned]) == [
        ("image-swapped", "warning", f"2 of 3 images of 'D1' have {columns} rows x {rows} columns")
    ]
    assert sized([(8, 6), (7, 7), (7, 7), (5, 5), (5, 5), (5, 5), (4, 4), (4, 4)]) == [
        ("image-size", "info", "3 of 8 images of 'D1' have 5 rows x 5 columns"),
        ("image-size", "info", "2 of 8 images of 'D1' have 7 rows x 7 columns"),
        ("image-size", "info", "2 of 8 images of 'D1' have 4 rows x 4 columns"),
    ]
    assert sized([turned], model="warpdrive") == []
    assert sized([turned], model="robotiq_ft300s") == []


def test_sizes_name_what_the_model_gives():
    """Rows come before columns, in both sentences."""
    rows, columns = SENSORS["digit"].camera.shape
    made = [take(frames(1, height=[h], width=[w])) for h, w in ((columns, rows), (8, 6))]
    texts = [said(one, lambda _: [np.zeros((8, 6, 3), np.uint8)])[0].message for one in made]
    assert texts[0].endswith(f"a digit gives {rows} x {columns}: height and width swapped")
    assert texts[1].endswith(f"a digit gives {rows} rows x {columns} columns")


def test_pictures_are_looked_at_at_the_start_in_the_middle_and_at_the_end():
    """Of each sensor's usable images three are decoded, and none of a sensor that has none."""
    asked = []
    flags = [FrameFlag.MISSING, 0, 0, 0, FrameFlag.OUTSIDE, 0, FrameFlag.BROKEN, FrameFlag.BROKEN]
    table = frames(8, sensor=["D1"] * 6 + ["D2"] * 2, flags=flags)
    assert said(take(table), lambda rows: asked.append(rows.tolist()) or [None] * len(rows)) == []
    assert asked == [[1, 3, 5]]


def channels(pictures, reference=None, model="digit"):
    references = {} if reference is None else {"D1": reference}
    rows, columns = SENSORS["digit"].camera.shape
    made = take(frames(3, height=rows, width=columns), sensors={"D1": {"model": model}}, references=references)
    return [one for one in said(made, lambda _: pictures) if one.code == "channels-swapped"]


def test_swapped_channels_are_judged_by_most_pictures():
    """Two of three BGR pictures are said, one of three is not, nor one of two; no picture says nothing."""
    assert channels([DIGIT] * 3) == channels([BGR, DIGIT, DIGIT]) == channels([None] * 3) == []
    assert channels([BGR, DIGIT, None]) == []
    [finding] = channels([BGR, BGR, DIGIT])
    assert finding.severity == "warning"
    assert "against known DIGIT sensors" in finding.message


def test_swapped_channels_are_judged_by_a_stated_background():
    """Channels of any model are judged by a stated background, not by a mean of its images or one of another size."""
    stated, mean = Reference(DIGIT, "backgrounds/D1.png"), Reference(BGR, "mean of 5 frames below 0.2 N")
    for model in ("digit", "gelsight_mini"):
        [finding] = channels([BGR] * 3, stated, model)
        assert "against the sensor's background" in finding.message
        assert channels([DIGIT] * 3, stated, model) == []
    assert channels([BGR] * 3, Reference(BGR, "a file"), "gelsight_mini") == []
    assert len(channels([BGR] * 3, mean)) == 1
    assert channels([BGR] * 3, mean, "gelsight_mini") == channels([BGR] * 3, None, "gelsight_mini") == []
    assert channels([BGR[::2]] * 3, stated) == []
    assert len(channels([BGR, DIGIT[::2], DIGIT[::2]], stated)) == 1


def test_known_colours_tell_which_picture_of_a_digit_is_swapped():
    """The images, the picture without contact, or both; neither where both are RGB, or where it lies on its side."""
    said_of = {
        name: [one.message.partition(" look like")[0] for one in channels([images] * 3, Reference(stated, "a file"))]
        for name, images, stated in (
            ("neither", DIGIT, DIGIT),
            ("images", BGR, DIGIT),
            ("background", DIGIT, BGR),
            ("both", BGR, BGR),
            ("on its side", BGR.swapaxes(0, 1), BGR.swapaxes(0, 1)),
        )
    }
    assert said_of == {
        "neither": [],
        "images": ["images of 'D1'"],
        "background": ["the picture without contact of 'D1'"],
        "both": ["images of 'D1' and its picture without contact"],
        "on its side": [],
    }


def test_half_of_the_pictures_are_no_proof_of_swapped_channels():
    """More than half must agree with a BGR picture without contact, and only pictures that can be compared count."""
    swapped = Reference(BGR, "a file")
    assert channels([BGR, DIGIT, None], swapped) == []
    assert channels([BGR[::2], BGR[::2], BGR[::2]], swapped) == []
    [both] = channels([BGR, BGR, DIGIT], swapped)
    assert both.message.startswith("images of 'D1' and its picture without contact look like BGR")
    [own] = channels([BGR, DIGIT, DIGIT], swapped)
    assert own.message.startswith("the picture without contact of 'D1' looks like BGR") or "its images" in own.message


@pytest.mark.parametrize("model", ["biotac", "gelsight_mini"])
def test_only_digits_have_known_colours(model):
    """Of other models, whatever their names, nothing is said without a picture, or where both are swapped alike."""
    assert channels([BGR] * 3, None, model) == []
    assert channels([BGR] * 3, Reference(BGR, "a file"), model) == []
    [finding] = channels([DIGIT] * 3, Reference(BGR, "a file"), model)
    assert finding.message.startswith("images of 'D1' look like BGR against the sensor's background")


def test_a_background_of_another_size_has_no_known_colours():
    """Only a picture as a DIGIT takes it is held against those of known DIGITs."""
    small = np.ascontiguousarray(BGR[:100, :100])
    assert channels([small] * 3, Reference(small, "a file")) == []


PRESSED = DIGIT.copy()
PRESSED[140:180, 100:140] //= 2


@pytest.mark.parametrize(
    ("stated", "shown", "force", "is_said"),
    [
        (PRESSED, DIGIT, 0.1, True),
        (DIGIT, DIGIT, 0.1, False),
        (DIGIT, PRESSED, 5.0, False),
        (PRESSED, DIGIT, 0.2, False),
        (PRESSED, DIGIT, np.nan, False),
    ],
)
def test_a_background_that_shows_a_touch_is_said(stated, shown, force, is_said):
    """Against frames in free air alone: pressed frames, and frames whose force is not known, prove nothing."""
    rows, columns = SENSORS["digit"].camera.shape
    table = frames(4, height=rows, width=columns, contact_force=force)
    for reference, expected in ((Reference(stated, "a file"), is_said), (Reference(stated, "mean of 3 frames"), False)):
        made = take(table, sensors={"D1": {"model": "digit"}}, references={"D1": reference})
        found = [one for one in said(made, lambda rows: [shown] * len(rows)) if one.code == "background-touched"]
        assert [one.severity for one in found] == ["warning"] * expected
        assert not found or "differs from 4 of its frames in free air" in found[0].message


@pytest.mark.parametrize("level", [0, 255])
def test_a_background_of_one_colour_is_said(level):
    """Black or white, also where no frame is in free air; a gel's picture is not."""
    rows, columns = SENSORS["digit"].camera.shape
    table = frames(4, height=rows, width=columns, contact_force=5.0)
    for picture, count in ((np.full_like(DIGIT, level), 1), (DIGIT, 0)):
        made = take(table, sensors={"D1": {"model": "digit"}}, references={"D1": Reference(picture, "a file")})
        found = said(made, lambda rows: [DIGIT] * len(rows))
        assert [one.severity for one in found if one.code == "background-blank"] == ["warning"] * count


def test_three_frames_in_free_air_are_needed_to_judge_a_background():
    """Two, or frames of another size, say nothing."""
    rows, columns = SENSORS["digit"].camera.shape
    for force, shown in (([0, 0, 9, 9], DIGIT), ([0, 0, 0, 0], DIGIT[::2])):
        table = frames(4, height=rows, width=columns, contact_force=force)
        made = take(table, sensors={"D1": {"model": "digit"}}, references={"D1": Reference(PRESSED, "a file")})
        assert "background-touched" not in {
            one.code for one in said(made, lambda rows, shown=shown: [shown] * len(rows))
        }


def touched(count, shown, stated=PRESSED, **columns):
    """Rows that are decoded for a background, and whether it is said to show a touch."""
    asked = []

    def decode(rows):
        asked.append(rows.tolist())
        return [shown(row) for row in rows.tolist()]

    rows, wide = SENSORS["digit"].camera.shape
    table = frames(count, height=rows, width=wide, **{"contact_force": 0.0, **columns})
    made = take(table, sensors={"D1": {"model": "digit"}}, references={"D1": Reference(stated, "a file")})
    return asked, [one.code for one in touched_findings("D1", made, decode)]


def test_eight_frames_in_free_air_judge_a_background():
    """From the first to the last of the sensor's own usable ones, evenly; where there are fewer, all of them."""
    assert touched(36, lambda _: DIGIT) == ([[0, 5, 10, 15, 20, 25, 30, 35]], ["background-touched"])
    assert touched(3, lambda _: DIGIT) == ([[0, 1, 2]], ["background-touched"])
    flags = [0, FrameFlag.BROKEN, 0, FrameFlag.MISSING, 0, 0]
    for other in ("D0", "D2"):
        sensor = ["D1"] * 5 + [other]
        assert touched(6, lambda _: DIGIT, flags=flags, sensor=sensor) == ([[0, 2, 4]], ["background-touched"])
    assert touched(2, lambda _: DIGIT) == ([], [])


def test_three_pictures_that_can_be_compared_judge_a_background():
    """Their middle level counts, so that one pressed picture among three changes nothing; two are too few."""
    assert touched(5, lambda row: DIGIT if row < 3 else None)[1] == ["background-touched"]
    assert touched(5, lambda row: DIGIT if row < 2 else DIGIT[::2])[1] == []
    assert touched(3, lambda row: PRESSED if row == 1 else DIGIT)[1] == ["background-touched"]
    assert touched(3, lambda row: PRESSED if row == 1 else DIGIT, DIGIT)[1] == []


def stuck(crc, force, **columns):
    return [
        one.count
        for one in said(take(frames(len(crc), crc32c=crc, contact_force=force, **columns)))
        if one.code == "camera-stuck"
    ]


def test_an_image_that_repeats_while_the_force_moves_by_a_newton():
    """More than 1 N over all repeats of an image; the repeats are counted, not the image itself."""
    assert stuck([7, 7, 7, 8], [0.0, 0.5, 1.25, 5]) == [2]
    assert stuck([7, 7, 7, 8], [0.0, 0.5, 1.0, 5]) == []
    assert stuck([8, 7, 7], [9.0, 3.0, 1.5]) == [1]
    assert stuck([7, 7], [0, 2]) == [1]
    assert stuck([7, 8, 9, 9], [0, 5, 0, 0]) == []
    assert stuck([7, 7, 7, 3, 4, 4, 9], [0, 1, 2, 0, 0, 3, 0]) == [3]
    assert stuck([7, 7, 7], [0, np.nan, 2]) == [2]
    assert stuck([7, 7, 5, 5], [0, 2, 0, 0.5]) == [1]
    assert stuck([7], [3]) == stuck([], []) == []


def test_what_is_no_repeat_of_an_image():
    """An image of another length, without bytes or in another trajectory is no repeat, whatever its checksum."""
    assert stuck([7, 7], [0, 2], length=[1, 2]) == []
    assert stuck([7, 7], [0, 2], length=[0, 0]) == []
    assert stuck([7, 7], [0, 2], trajectory=[0, 1]) == []


def test_forces_beyond_the_range_of_the_sensor():
    """300 N are a force, more is none; torques have a range of their own."""
    values = np.zeros((4, 6))
    values[0, 0], values[1, 2], values[2, 1] = FT_RANGE, -np.nextafter(FT_RANGE, 400), 1e5
    (found,) = said(take(signals={"wrench": signal("wrench", range(4), values)}))
    assert told([found]) == [("force-out-of-range", "warning", "wrench", 2)]
    assert FT_RANGE == 300.0
    assert "2 samples are beyond 300 N" in found.message
    assert said(take(signals={"wrench": signal("wrench", range(1), values[:1])})) == []


@pytest.mark.parametrize("column", [3, 4, 5])
def test_torques_beyond_the_range_of_the_sensor(column):
    """30 N m are a torque; an offset of 50 N m in every sample is none, although it would be taken off as a zero."""
    values = np.zeros((4, 6))
    values[:, column] = 30.0
    assert "torque-out-of-range" not in codes_of(values)
    values[:, column] = -50.0
    found = said(take(signals={"wrench": signal("wrench", range(4), values)}))
    assert ("torque-out-of-range", "warning", "wrench", 4) in told(found)
    text = next(one.message for one in found if one.code == "torque-out-of-range")
    assert "4 samples are beyond 30 N m, the range of" in text
    values[:, column] = 30.5
    assert "torque-out-of-range" in codes_of(values)


@pytest.mark.parametrize("column", range(6))
def test_each_component_is_held_against_its_own_range(column):
    """A load of 400 beyond both ranges is said of forces in one of the first three columns, else of torques."""
    values = np.zeros((4, 6))
    values[2, column] = 400.0
    beyond = {code for code in codes_of(values) if code.endswith("-out-of-range")}
    assert beyond == {"force-out-of-range" if column < 3 else "torque-out-of-range"}


def codes_of(values):
    found = said(take(signals={"wrench": signal("wrench", range(len(values)), values)}))
    return {one.code for one in found}


def test_a_mesh_that_is_not_there_is_named(tmp_path):
    """A missing mesh of an indenter or a gel is named, for a file and a folder; one that is there says nothing."""
    (tmp_path / "run").mkdir()
    document = {
        "indenters": {"part": {"mesh": "solids/part.stl", "unit": "mm"}, "ball": {"shape": "sphere", "radius": 0.002}},
        "sensors": {"D1": {"gel": {"mesh": "gel.msh"}}},
    }

    def missing(path):
        one = dataclasses.replace(take(description=document), source=Source(str(path), "run", "mcap", ()))
        return [finding for finding in said(one) if finding.code == "mesh-missing"]

    def path_of(place):
        return place if place.is_dir() else tmp_path

    for place in (tmp_path / "run", tmp_path / "run.mcap"):
        found = missing(place)
        assert [one.severity for one in found] == ["warning"] * 2
        assert "indenters.part names the mesh 'solids/part.stl'" in found[0].message
        assert "sensors.D1.gel names the mesh 'gel.msh'" in found[1].message
        assert "--indenters FOLDER" in found[0].message
        assert f"there is no such file in {path_of(place)}:" in found[0].message
    (tmp_path / "solids").mkdir()
    (tmp_path / "solids" / "part.stl").write_bytes(b"solid")
    (tmp_path / "run" / "gel.msh").write_bytes(b"")
    assert missing(tmp_path / "run") == []
    assert [one.message.split(" ")[0] for one in missing(tmp_path / "run.mcap")] == ["sensors.D1.gel"]


def test_a_mesh_outside_of_the_recording_is_not_looked_for(tmp_path):
    """A path that leads out has a finding of its own; a link that leads out is no file beside the recording."""
    (tmp_path / "run").mkdir()
    (tmp_path / "outside.stl").write_bytes(b"solid")
    (tmp_path / "run" / "inside.stl").symlink_to(tmp_path / "outside.stl")

    def missing(name):
        one = LogDescription({"indenters": {"part": {"mesh": name, "unit": "mm"}}})
        return [finding.code for finding in mesh_findings(one, tmp_path / "run")]

    assert missing("../nobody.stl") == missing("/nobody.stl") == []
    assert missing("inside.stl") == missing("nobody.stl") == ["mesh-missing"]
    assert missing("outside.stl") == []


def empty_of(count, table=None):
    rows = [touch("full"), *(touch(f"e{n}", 0, 1000, 1, 1) for n in range(count))]
    made = take(frames(1) if table is None else table, rows)
    return [one for one in said(made) if one.code == "trajectory-without-frames"]


def test_trajectories_without_images_are_named():
    """Five by name, the others by a sign; where there are no images at all nothing is said."""
    assert empty_of(0) == []
    assert [(one.count, one.message) for one in empty_of(1)] == [(1, "1 trajectory holds no image (e0)")]
    assert empty_of(5)[0].message == "5 trajectories hold no image (e0, e1, e2, e3, e4)"
    assert empty_of(6)[0].message == "6 trajectories hold no image (e0, e1, e2, e3, e4 …)"
    assert empty_of(1, frames(0)) == []


def test_a_sound_take_says_nothing():
    """Nor does one without anything."""
    assert said(take()) == said(take(frames(3), [touch()])) == []


def test_images_that_are_not_in_the_spool_are_not_asked_for():
    """A spool without encoded images opens no file."""
    images = SpooledImages(None, frames(1, encoding="raw").select(["encoding"]))
    assert broken_images(images)[0].tolist() == []
