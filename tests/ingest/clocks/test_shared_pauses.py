"""Pauses that streams share are pauses: no stream that stops early makes jumps of one stream's clock of them."""

import io
import json

import numpy as np
import pytest
from generators.collect import read
from generators.mcap_files import START as TAPE_START
from generators.mcap_files import Tape, numbers, picture
from mcap.reader import make_reader

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.formats.mcap.mcap import McapFormat
from tactiledata.ingest.clocks.clock_shifts import judge_frames
from tactiledata.ingest.clocks.clock_steps import judge_steps
from tactiledata.ingest.clocks.timeline import put_on_host_clock
from tactiledata.ingest.clocks.witnesses import IMAGES, SIGNAL, Witness, pauses_of, shown_from, silences_of

START = 1_700_000_000_000_000_000
MS, SECOND = 1_000_000, 1_000_000_000
TOUCHES = 12
WIDTHS = {"wrench": 6, "tcp": 7, "temperature": 1}


def in_touches(period_ms, pause_s=1.0):
    """Times (n,) of a stream that is only recorded in twelve touches of 4 s."""
    one = np.arange(0, 4000, period_ms) * MS
    return START + np.concatenate([one + int(k * (4 + pause_s) * SECOND) for k in range(TOUCHES)])


def throughout(period_ms, seconds):
    return START + np.arange(0, int(1000 * seconds), period_ms) * MS


def recording(**times):
    signals = {}
    for name, t_ns in times.items():
        values = np.random.default_rng(0).normal(size=(len(t_ns), WIDTHS[name]))
        if name == "tcp":
            values[:, 3:] = 0, 0, 0, 1
        columns = tuple(f"{name}{k}" for k in range(WIDTHS[name]))
        signals[name] = Signal(name, Stamps(t_ns), values, columns)
    touches = tuple(Trajectory(f"t{k}", START + k * 5 * SECOND, START + (k * 5 + 4) * SECOND) for k in range(TOUCHES))
    return Recording(Source("p", "k", "folder", ()), LogDescription({}), signals, touches)


def outcome(times, camera=None):
    """Samples of the wrench that are left, and the codes of what is said of clocks."""
    timed = put_on_host_clock(recording(**times), {} if camera is None else {"digit": camera})
    said = {finding.code for finding in timed.findings if finding.code in ("clock-jump", "clock-apart")}
    return len(timed.signals["wrench"].t_ns), said


@pytest.mark.parametrize("has_camera", [True, False])
@pytest.mark.parametrize("earlier", [None, 0.0, 1.0, 2.0, 4.0, 7.0])
@pytest.mark.parametrize("slow_ms", [500, 100])
def test_pauses_between_touches_are_no_jumps(has_camera, earlier, slow_ms):
    """Negative control: all pause for 1 s between touches, and a slow signal goes on and stops earlier by whole pauses.

    Every number of such pauses adds up to the time by which it lasts shorter.
    """
    times = {"wrench": in_touches(10), "tcp": in_touches(10)}
    if earlier is not None:
        times["temperature"] = throughout(slow_ms, 59.001 - earlier)
    assert outcome(times, in_touches(40) if has_camera else None) == (4800, set())


@pytest.mark.parametrize("ends", [0.0, 1.0, 3.0])
def test_pauses_of_all_fast_signals_beside_images_that_stop_early_are_no_jumps(ends):
    """Negative control: the controller pauses between touches, a slow signal and the images go on and stop early."""
    times = {"wrench": in_touches(10), "tcp": in_touches(10), "temperature": throughout(500, 55.001)}
    assert outcome(times, throughout(40, 59 - ends)) == (4800, set())


@pytest.mark.parametrize("pauses", [False, True])
@pytest.mark.parametrize("has_slow", [False, True])
@pytest.mark.parametrize("seconds", [1, 3, 5])
def test_a_jump_among_shared_pauses_is_found(pauses, has_slow, seconds):
    """The wrench alone jumps inside the sixth touch: what lies behind it is left out, and nothing else."""
    wrench = in_touches(10) if pauses else throughout(10, 59)
    row = len(wrench) * 11 // 24
    jumped = wrench + np.where(np.arange(len(wrench)) >= row, seconds * SECOND, 0)
    times = {"wrench": jumped, "tcp": in_touches(10) if pauses else throughout(10, 59)}
    if has_slow:
        times["temperature"] = throughout(500, 55.001)
    for camera in (None, in_touches(40) if pauses else throughout(40, 59)):
        assert outcome(times, camera) == (row, {"clock-jump"})


def test_of_equal_pauses_nobody_knows_which_was_the_jump():
    """A stream that pauses alone eight times, and lasts 3 s longer than another: any three could be jumps."""
    t_ns = in_touches(10)
    judged = judge_steps("wrench", t_ns, np.zeros((len(t_ns), 1)), [Witness(SIGNAL, START, int(t_ns[-1]) - 3 * SECOND)])
    assert judged.kept.all()
    assert [finding.code for finding in judged.findings] == ["pause-or-jump"]


@pytest.mark.parametrize("pause_s", [1.0, 5.0])
def test_images_that_are_silent_show_a_pause(pause_s):
    """What the images share is a pause, though a signal goes on and lasts shorter by just that; without them it tells.

    The length of one pause: its chance is one in many, and the images speak against it.
    """
    t_ns = np.concatenate([throughout(10, 20), throughout(10, 20) + int((20 + pause_s) * SECOND)])
    length = int(t_ns[-1] - t_ns[0] - pause_s * SECOND)
    goes_on = Witness(SIGNAL, START, START + length)
    filmed = t_ns[::4]
    images = Witness(IMAGES, int(filmed[0]), int(filmed[-1]), silences_of(filmed))
    values = np.random.default_rng(0).normal(size=(len(t_ns), 1))
    assert judge_steps("wrench", t_ns, values, [goes_on, images]).findings == ()
    assert [one.code for one in judge_steps("wrench", t_ns, values, [goes_on]).findings] == ["clock-jump"]


def test_what_a_stream_can_show():
    """Steps of three of its periods and more; a longer one is a silence from 0.3 s on, though it may be no pause."""
    assert shown_from(throughout(10, 1)) == shown_from(throughout(100, 9)) == 0
    assert silences_of(START + np.array([0, 10, 20, 320, 330, 631]) * MS) == ((START + 330 * MS, 301 * MS),)
    assert shown_from(throughout(500, 9)) == 1500 * MS
    t_ns = START + np.array([0, 500, 1000, 2500, 3000, 4501]) * MS
    assert silences_of(t_ns) == ((START + 3000 * MS, 1501 * MS),)
    assert pauses_of(t_ns) == ()
    slow = Witness(SIGNAL, START, START + 3 * SECOND, (), shown_from(t_ns))
    fast = Witness(SIGNAL, START, START + 3 * SECOND)
    wrench = np.concatenate([throughout(10, 2), throughout(10, 1) + 3 * SECOND])
    values = np.random.default_rng(0).normal(size=(len(wrench), 1))
    assert [one.code for one in judge_steps("wrench", wrench, values, [fast]).findings] == ["clock-jump"]
    assert [one.code for one in judge_steps("wrench", wrench, values, [slow]).findings] == ["pause-or-jump"]


def test_a_camera_that_pauses_with_a_signal_is_kept():
    """Negative control: camera and wrench halt for 4 s while a thermometer goes on that stops 4 s early."""
    halted = np.r_[0:2000, 2400:6000]
    wrench, filmed = throughout(10, 60)[halted], throughout(10, 60)[halted][::4]
    signals = {"wrench": wrench, "temperature": throughout(500, 56)}
    found = judge_frames(
        recording(**signals), {"digit": np.arange(len(filmed))}, filmed, np.arange(len(filmed)), signals
    )
    assert not found.is_off.any()
    assert found.findings == ()


def taped(path, stops):
    """12 s in chunks of about a second: wrench and a slow number without stamps of their own, tcp, and images.

    The slow number stops earlier by some seconds.
    """
    wrench, tcp = numbers(1200, 6, 1).round(3), numbers(1200, 7, 2)
    with Tape(path, compression="none", chunk_size=47_000) as file:
        for index in range(1200):
            at = TAPE_START + index * 10 * MS
            force = json.dumps({"f": wrench[index].tolist()}).encode()
            file.raw("/force", at, force, "F", "jsonschema", "json", b"{}")
            file.signal("tcp", at, at, tcp[index])
            if index % 50 == 0 and index < 1200 - 100 * stops:
                file.raw("/temperature", at, b'{"v": 20.5}', "T", "jsonschema", "json", b"{}")
            if index % 4 == 0:
                file.image(at, at, picture(index, 16, 12))


@pytest.mark.slow
@pytest.mark.parametrize("stops", [0, 1])
def test_a_lost_chunk_is_a_pause(tmp_path, stops):
    """Negative control: whichever chunk one flipped bit costs, no clock jumps, and all other samples are kept."""
    taped(tmp_path / "run.mcap", stops)
    content = (tmp_path / "run.mcap").read_bytes()
    summary = make_reader(io.BytesIO(content)).get_summary()
    chunks = [(index.chunk_start_offset, index.chunk_length) for index in summary.chunk_indexes]
    assert len(chunks) > 6
    mapping = {
        "format": "tactiledata-mapping/1",
        "clock": "log",
        "signals": {
            "wrench": {"topic": "/force", "fields": [f"f[{k}]" for k in range(6)]},
            "temperature": {"topic": "/temperature", "fields": ["v"], "units": ["K"]},
        },
    }
    said = []
    for place, length in chunks:
        damaged = bytearray(content)
        damaged[place + length // 2] ^= 1
        (tmp_path / "lost.mcap").write_bytes(damaged)
        [(found, sink)] = read(McapFormat(), tmp_path / "lost.mcap", mapping)
        n_read = len(found.signals["wrench"].stamps)
        assert n_read < 1200
        timed = put_on_host_clock(found, {"digit": np.array([image.log_ns for image in sink.images])})
        said.append({finding.code for finding in timed.findings} & {"clock-jump", "clock-apart"})
        said[-1] |= {"fewer"} if len(timed.signals["wrench"].t_ns) < n_read else set()
    assert said == [set()] * len(chunks)
