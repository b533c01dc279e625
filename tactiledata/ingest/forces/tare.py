"""The zero of a force sensor: stated tare events, or what it reads in free air."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Finding, Times, Values
from tactiledata.contract.wording import counted, listed
from tactiledata.ingest.forces.onset import (
    MIN_FREE_AIR,
    RELEASE_SHARE,
    SURELY_FREE,
    before_touch,
    component_noise,
    touch_threshold,
    touching,
)
from tactiledata.ingest.forces.tare_events import (
    PAUSE,
    Tare,
    contradicted_findings,
    locate_tares,
    tares_near,
    without_steps,
)
from tactiledata.ingest.forces.zero_findings import (
    drift_findings,
    pressed_findings,
    trusted_findings,
    under_load_findings,
)
from tactiledata.ingest.forces.zero_levels import (
    ends_of,
    free_beginnings,
    moved_findings,
    moved_zeros,
    pressed_beginnings,
)

MAX_DRIFT = 5.0
"""N. A trajectory whose start is farther than this from the recording's zero starts in contact, not in free air."""


SLOWEST_PRESS = 5_000_000_000
"""ns. A force that takes longer from free air to the touching threshold is drift of the sensor, not a touch."""


@dataclass(frozen=True)
class Zero:
    """What was subtracted from a wrench.

    Parameters
    ----------
    bias : (n, 6)
        N and N m, per sample.
    method : str
        In words, for provenance.
    noise : float
        N, standard deviation of one force component in free air.
    findings : tuple of Finding
    """

    bias: Values
    method: str
    noise: float
    findings: tuple[Finding, ...]


def half_sample_mode(samples: Values) -> float:
    """The densest value of samples (n,): the zero of a signal that is at rest more often than at any other level.

    Source: Robertson and Cryer 1974 (half-sample mode); robust where the mean and the median follow the contacts.
    """
    rows = np.sort(samples[np.isfinite(samples)])
    if not len(rows):
        return 0.0
    while len(rows) > 3:
        half = (len(rows) + 1) // 2
        widths = rows[half - 1 :] - rows[: len(rows) - half + 1]
        start = int(np.argmin(widths))
        rows = rows[start : start + half]
    return float(rows.mean())


def find_zero(
    t_ns: Times,
    load: Values,
    spans: list[tuple[str, int, int]],
    tare_ns: list[int],
    tare_zeros: Values | None = None,
) -> Zero:
    """The zero of a wrench from which the tool's weight is already taken off.

    Parameters
    ----------
    t_ns : (n,) int64
    load : (n, 6)
        N and N m; weight of the tool subtracted where it is known.
    spans : list of (name, start_ns, end_ns)
        Named trajectories; each is expected to begin in free air.
    tare_ns : list of int
        Stated tare events: the reading was set to zero then, so the zero jumps there.
    tare_zeros : (k, 6), optional
        The load that a reading of zero is at each event: minus the tool's weight there; 0 where that is not taken off.

    Notes
    -----
    Each trajectory gets the median of its own free air before the first touch, because the sensor drifts by newtons
    within minutes after power-on (see docs/ingest.md); where a tare event falls inside, the zero jumps with the
    reading. A trajectory without free air gets the nearest zero that is known between the same two tare events: that
    of another trajectory, or of the event. Only where nothing is known, the mode of each component is taken.
    """
    noise = component_noise(load[np.isfinite(load).all(axis=1)])
    stated = np.zeros((len(tare_ns), 6)) if tare_zeros is None else tare_zeros
    is_near, far = tares_near(t_ns, tare_ns)
    near = [moment for moment, kept in zip(tare_ns, is_near, strict=True) if kept]
    tares, contradicted = locate_tares(t_ns, load, near, stated[is_near], noise)
    bias, pressed_tares = _general_zeros(t_ns, load, tares, noise)
    findings = [*far, *_tare_findings(t_ns, tare_ns, tares, spans), *contradicted_findings(contradicted)]
    if not spans:
        findings.extend(under_load_findings(pressed_tares))
        return Zero(bias, "between tare events: the stated zero, or the mode of the recording", noise, tuple(findings))
    missed: list[tuple[str, int, int]] = []
    trusted: list[tuple[str, float]] = []
    zeros: list[np.ndarray] = []
    known: list[tuple[int, np.ndarray]] = [(tare.row, bias[tare.row]) for tare in tares]
    ordered = sorted(spans, key=lambda span: span[1])
    ends = [each for each in (ends_of(t_ns, load, tares, span) for span in ordered) if each is not None]
    pressed = pressed_beginnings(ends, tares, touch_threshold(noise))
    surely_free = free_beginnings(ends, tares, pressed)
    findings.extend(moved_findings(moved_zeros(ends, tares, pressed, touch_threshold(noise))))
    for name, start_ns, end_ns in ordered:
        start, stop = (int(row) for row in np.searchsorted(t_ns, [start_ns, end_ns]))
        if start == stop:  # without samples nobody knows where it begins
            continue
        general = bias[start].copy()
        pieces = (
            []
            if name in pressed
            else _piece_zeros(t_ns, load, tares, (start, stop), bias[start], noise, name in surely_free)
        )
        if not pieces:
            missed.append((name, start, stop))
            continue
        if name in surely_free and (away := _newtons(pieces[0][1] - general)) > MAX_DRIFT:
            trusted.append((name, away))
        zeros.append(pieces[-1][1])
        known.extend(pieces)
        for (row, zero), end in zip(pieces, [row for row, _ in pieces[1:]] + [stop], strict=True):
            bias[row:end] = zero
    for _, start, stop in missed:
        _take_nearest(bias, known, tares, start, stop)
    findings.extend(drift_findings(zeros))
    findings.extend(pressed_findings([(name, _begins_off(load, bias, start, stop)) for name, start, stop in missed]))
    findings.extend(trusted_findings(trusted))
    return Zero(bias, "median of each trajectory's free air before the first touch", noise, tuple(findings))


def _general_zeros(
    t_ns: Times, load: Values, tares: list[Tare], noise: float
) -> tuple[Values, list[tuple[int, float]]]:
    """The zero (n, 6) between tare events: what the event states, unless it happened while something pressed.

    Such events come beside it, with their time, ns, and the force, N, that was taken for one of a contact.

    Before the first event it is the mode, where the recording begins at it; else what the load was before the jump, or
    at the start of the recording, where something pressed at the event.
    """
    bias = np.zeros((len(load), 6))
    first = tares[0].row if tares else len(load)
    mode = np.array([half_sample_mode(load[:first, axis]) for axis in range(6)])
    if tares and first:
        rows = load[:first][np.isfinite(load[:first]).all(axis=1)][:MIN_FREE_AIR]
        begins = np.median(rows, axis=0) if len(rows) else mode
        if np.linalg.norm((begins - mode)[:3]) > touch_threshold(noise) or len(rows) < MIN_FREE_AIR:
            # the mode may be the force of a long dwell; a tare while something pressed leaves the level at the start
            pressed = len(rows) >= MIN_FREE_AIR and _was_pressed(t_ns[:first], load[:first], begins, noise)
            mode = begins if pressed else tares[0].zero - tares[0].step
    bias[:first] = mode
    borders = [0, *(tare.row for tare in tares), len(load)]
    under_load: list[tuple[int, float]] = []
    for number, tare in enumerate(tares):
        start = borders[number]
        pressed = _was_pressed(t_ns[start : tare.row], load[start : tare.row], bias[start], noise)
        bias[tare.row : borders[number + 2]] = bias[tare.row - 1] + tare.step if pressed else tare.zero
        if pressed:
            under_load.append((int(t_ns[tare.row]), _newtons(load[tare.row - 1] - bias[tare.row - 1])))
    return bias, under_load


def _was_pressed(t_ns: Times, load: Values, zero: np.ndarray, noise: float) -> bool:
    """Whether something presses at the end of a stretch: the force rose within seconds, as no drift does."""
    force = np.linalg.norm((load - zero)[:, :3], axis=1)
    threshold = touch_threshold(noise)
    contact = touching(np.nan_to_num(force, nan=0.0), threshold)
    if not len(contact) or not contact[-1] or contact.all():
        return False
    onset = int(np.flatnonzero(~contact)[-1]) + 1
    free = np.flatnonzero(force[:onset] < RELEASE_SHARE * threshold)
    if not len(free) or t_ns[onset] - t_ns[free[-1]] >= SLOWEST_PRESS:
        return False
    # over a pause nothing was seen to rise: the zero may have changed
    return bool((np.diff(t_ns[free[-1] : onset + 1]) <= PAUSE).all())


def _piece_zeros(
    t_ns: Times,
    load: Values,
    tares: list[Tare],
    rows: tuple[int, int],
    general: np.ndarray,
    noise: float,
    is_surely_free: bool,
) -> list[tuple[int, np.ndarray]]:
    """First row and zero (6,) of each piece of a trajectory between tare events; none where it has no free air.

    One that begins far from the recording's zero has none, unless its neighbours show that it does, and it has a touch.
    """
    start, stop = rows
    inside = [tare for tare in tares if start < tare.row < stop]
    steady = without_steps(load, inside, start, stop)
    sound = np.flatnonzero(np.isfinite(steady).all(axis=1))
    if len(sound) < MIN_FREE_AIR:
        return []
    first = np.median(steady[sound[:MIN_FREE_AIR]], axis=0)
    contact = touching(np.linalg.norm((steady[sound] - first)[:, :3], axis=1), touch_threshold(noise))
    # with a tare inside, nothing of what was read before it tells of its zero: the trajectory's other end does
    is_free = contact.any() and (is_surely_free or (len(inside) > 0 and not contact[-1]))
    if np.linalg.norm((first - general)[:3]) > MAX_DRIFT and not is_free:
        return []
    touched = np.flatnonzero(contact)
    before = int(touched[0]) if len(touched) else len(sound)
    free = sound[: before_touch(before, steady[sound], t_ns[start + sound])]
    borders = [start, *(tare.row for tare in inside), stop]
    zeros = [_free_air_zero(load, free + start, begin, end) for begin, end in itertools.pairwise(borders)]
    steps = np.cumsum([np.zeros(6), *(tare.step for tare in inside)], axis=0)
    own = [number for number, zero in enumerate(zeros) if zero is not None]
    if not own:
        return []
    pieces = []
    for number, begin in enumerate(borders[:-1]):
        near = min(own, key=lambda other: abs(other - number))
        zero = zeros[near]
        assert zero is not None
        pieces.append((begin, zero + steps[number] - steps[near]))
    return pieces


def _free_air_zero(load: Values, free: np.ndarray, begin: int, end: int) -> np.ndarray | None:
    """Median (6,) of what is surely free air of rows [begin, end); ``None`` where there are too few."""
    free = free[free >= begin]
    surely = free[: max(MIN_FREE_AIR, int(SURELY_FREE * len(free)))]
    surely = surely[surely < end]
    return np.median(load[surely], axis=0) if len(surely) >= MIN_FREE_AIR else None


def _take_nearest(bias: Values, known: list[tuple[int, np.ndarray]], tares: list[Tare], start: int, stop: int) -> None:
    """Give rows [start, stop) the zeros that are known nearest to them, between the same two tare events."""
    borders = np.array([tare.row for tare in tares], dtype=np.int64)
    inside = [int(row) for row in borders if start < row < stop]
    for begin, end in itertools.pairwise([start, *inside, stop]):
        place = np.searchsorted(borders, begin, side="right")
        near = [(row, zero) for row, zero in known if np.searchsorted(borders, row, side="right") == place]
        if near:
            bias[begin:end] = min(near, key=lambda entry: abs(entry[0] - begin))[1]


def _newtons(difference: np.ndarray) -> float:
    return float(np.linalg.norm(difference[:3]))


def _begins_off(load: Values, bias: Values, start: int, stop: int) -> float:
    """N. How far the first sound samples of a trajectory are from the zero that it was given; NaN without any."""
    rows = start + np.flatnonzero(np.isfinite(load[start:stop]).all(axis=1))[:MIN_FREE_AIR]
    return _newtons(np.median(load[rows] - bias[rows], axis=0)) if len(rows) else np.nan


def _tare_findings(
    t_ns: Times, tare_ns: list[int], tares: list[Tare], spans: list[tuple[str, int, int]]
) -> list[Finding]:
    if not tare_ns:
        text = "wrench: no tare event is stated; the zero is taken from free air"
        return [Finding("zero-from-free-air", "info", text, "wrench")]
    inside = [name for name, start, end in spans if any(start < t_ns[tare.row] < end for tare in tares if tare.row)]
    if not inside:
        return []
    text = (
        f"wrench: a tare event falls inside {counted(len(inside), 'trajectory')} ({listed(inside, 5)}); "
        "the reading jumps there, and the zero of its contact force with it"
    )
    return [Finding("tare-in-trajectory", "info", text, "wrench", count=len(inside))]
