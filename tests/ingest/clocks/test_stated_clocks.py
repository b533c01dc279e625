"""Clock offsets and moments of power-on that are stated, and are true, never make forces worse."""

import numpy as np
import pytest
from few_examples import few
from hypothesis import example, given
from hypothesis import strategies as st
from test_stated_tares import ALL, TOUCH_SECONDS, WITHIN, World

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Signal, Source, Stamps
from tactiledata.ingest.clocks.align import align
from tactiledata.ingest.clocks.timeline import put_on_host_clock
from tactiledata.ingest.forces.contact import contact_wrench

KINDS = ("header", "unset header", "one stamp")
FACTS = ("wrench", "tcp", "power_on_ns")


def stamped(t_ns, kind, offset_ns, delay_ns):
    """Stamps of samples at host times, of a sender whose clock is the offset behind."""
    own = t_ns - offset_ns
    if kind == "one stamp":
        return Stamps(own)
    return Stamps(t_ns + delay_ns, own, own if kind == "header" else np.zeros_like(own))


def error(world, kind, offsets, delay_ns, stated):
    """N: the largest mean error of the force over the dwell of a touch; infinite where a touch has no force."""
    document = dict(world.described(ALL).document)
    document["clocks"] = {name: {"offset_ns": offsets[name], "known": True} for name in offsets if name in stated}
    if "power_on_ns" in stated:
        document["sensors"] = {"D1": {"model": "digit", "power_on_ns": [int(world.t_ns[0]) - 10**11]}}
    description = LogDescription.checked(document, "test")
    plain = {"wrench": world.wrench, "tcp": world.tcp}
    signals = {
        name: Signal(name, stamped(signal.t_ns, kind, offsets[name], delay_ns), signal.values, signal.columns)
        for name, signal in plain.items()
    }
    recording = Recording(Source("a", "a", "mcap", ()), description, signals, host_clock="auto")
    timed = put_on_host_clock(recording).signals
    answer = contact_wrench(description, timed["wrench"], timed["tcp"], world.spans)
    off = (align(answer.signal, world.t_ns).values - world.truth)[:, :3]
    touches = world.seconds // TOUCH_SECONDS
    dwells = [off[(touches == touch) & world.pressed] for touch in np.unique(touches)]
    means = [dwell[np.isfinite(dwell).all(axis=1)].mean(axis=0) for dwell in dwells if np.isfinite(dwell).any()]
    return max(np.linalg.norm(mean) for mean in means) if len(means) == len(dwells) else np.inf


@pytest.mark.parametrize("offset_s", [-40.0, -3.0, 0.0, 3.0])
@pytest.mark.parametrize("kind", KINDS)
def test_forces_are_right_on_whatever_clock_the_streams_were(kind, offset_s):
    """Header stamps, none, or one stamp for all: with the true offsets stated, the planted forces come back."""
    world = World(3, 3, 2.0, [0.1])
    offsets = {"wrench": int(offset_s * 1e9), "tcp": int(offset_s / 2 * 1e9)}
    assert error(world, kind, offsets, 15_000_000, FACTS) < WITHIN


@pytest.mark.slow
@few(25)
@example(0, "header", 0.0, 0.0, 4.0, set())
@given(
    st.integers(0, 10**6),
    st.sampled_from(KINDS),
    st.floats(-60, 60),
    st.floats(-60, 60),
    st.floats(0, 4),
    st.sets(st.sampled_from(FACTS)),
)
def test_true_clocks_never_make_forces_worse(seed, kind, wrench_s, tcp_s, delay_s, kept):
    """All clocks stated give forces no worse than some of them do; late log times do not matter beside headers."""
    world = World(seed, 2, 2.0, [0.1])
    offsets = {"wrench": int(wrench_s * 1e9), "tcp": int(tcp_s * 1e9)}
    delay_ns = int(delay_s * 1e9) if kind == "header" else 10_000_000
    whole = error(world, kind, offsets, delay_ns, FACTS)
    assert whole < WITHIN
    assert whole < error(world, kind, offsets, delay_ns, kept) + 0.05
