"""The contact wrench, derived from the force sensor's reading: what the gel exerts on the indenter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, Times, Values
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.gravity import tool_weight, what_weight_needs, without_pose
from tactiledata.ingest.forces.tare import Zero, find_zero
from tactiledata.transforms import move_wrench
from tactiledata.units import SIGNAL_COLUMNS, signal_units

FIRM = 1.0
"""N. Largest force of a touch from which on its direction tells something."""
PULLS = 0.5
"""Share of a force that points into the gel, from which on the touch pulls."""
NEARLY_ALL = 0.8
"""Share of touches that pull, from which on the sign is doubted."""


@dataclass(frozen=True)
class ContactWrench:
    """The derived stream, the noise of the reading (N, one component), and what is to be said about both."""

    signal: StoredSignal
    noise: float
    findings: tuple[Finding, ...]


def contact_wrench(
    description: LogDescription,
    wrench: StoredSignal,
    tcp: StoredSignal | None,
    spans: list[tuple[str, int, int]],
) -> ContactWrench:
    """What the gel exerts on the indenter, in the gel frame, torque about the gel's origin: pressing gives Fz > 0.

    Parameters
    ----------
    description : LogDescription
        Sign, gravity, tare events, tool, ``tcp_from_gel`` and ``tcp_from_ft``. Without the transforms the wrench stays
        in the ft frame (its norm is the same), and a finding says so.
    wrench : StoredSignal
        As measured.
    tcp : StoredSignal or None
        Needed to take off the tool's weight.
    spans : list of (name, start_ns, end_ns)
        Trajectories, for the zero.
    """
    findings: list[Finding] = []
    stated = description.wrench
    load = wrench.values if stated.get("sign", "load_on_sensor") == "load_on_sensor" else -wrench.values
    if "sign" not in stated:
        findings.append(
            Finding("sign-assumed", "warning", "wrench: its sign is not stated; load_on_sensor assumed", "wrench")
        )
    load, gravity = _without_weight(description, wrench, tcp, load, findings)
    tare_ns = list(stated.get("tare_ns", []))
    zero = find_zero(wrench.t_ns, load, spans, tare_ns, zeros_at(description, tcp, tare_ns))
    findings.extend(zero.findings)
    values, frame = _in_gel_frame(description, load - zero.bias, findings)
    if frame == "gel":
        findings.extend(_sign_findings(stated.get("sign", "load_on_sensor"), wrench.t_ns, values, spans))
    return ContactWrench(_stored(wrench, values, frame, gravity, zero), zero.noise, tuple(findings))


def _sign_findings(sign: str, t_ns: Times, values: Values, spans: list[tuple[str, int, int]]) -> list[Finding]:
    """A finding where nearly all touches pull: the gel pushes the indenter out, so that Fz > 0 in the gel frame."""
    pulling, touches = [], 0
    for name, start_ns, end_ns in spans:
        start, stop = (int(row) for row in np.searchsorted(t_ns, [start_ns, end_ns]))
        force = values[start:stop, :3]
        force = force[np.isfinite(force).all(axis=1)]
        norm = np.linalg.norm(force, axis=1)
        if not len(norm) or norm.max() < FIRM:
            continue
        touches += 1
        rows = norm >= norm.max() / 2
        if np.median(force[rows, 2] / norm[rows]) < -PULLS:
            pulling.append(name)
    if not touches or len(pulling) < NEARLY_ALL * touches:
        return []
    other = "reaction" if sign == "load_on_sensor" else "load_on_sensor"
    text = (
        f"wrench: in {len(pulling)} of {touches} touches (for example {', '.join(pulling[:3])}) pressing gives Fz < 0 "
        f"in the gel frame, where the gel should push with Fz > 0; the sign was taken as {sign}. State wrench.sign: "
        f"{other} if the sensor reads so, or mend the rotations of robot.tcp_from_gel and robot.tcp_from_ft"
    )
    return [Finding("sign-reversed", "warning", text, "wrench", count=len(pulling))]


def zeros_at(description: LogDescription, tcp: StoredSignal | None, tare_ns: list[int]) -> Values:
    """What the load (k, 6) is where the sensor reads zero at k moments: minus the tool's weight, where it is taken off.

    Parameters
    ----------
    description : LogDescription
    tcp : StoredSignal or None
    tare_ns : list of int
        Host clock.
    """
    moments = np.asarray(tare_ns, dtype=np.int64)
    taken_off = description.wrench.get("gravity") != "compensated"
    weight = tool_weight(description, tcp, moments) if taken_off else None
    return np.zeros((len(moments), 6)) if weight is None else -weight


def _without_weight(
    description: LogDescription,
    wrench: StoredSignal,
    tcp: StoredSignal | None,
    load: np.ndarray,
    findings: list[Finding],
) -> tuple[np.ndarray, str]:
    if description.wrench.get("gravity") == "compensated":
        return load, "compensated by the recorder"
    weight = tool_weight(description, tcp, wrench.t_ns)
    if weight is None:
        text = (
            "wrench: the tool's weight was not taken off, because the recording lacks "
            f"{' and '.join(what_weight_needs(description, tcp))}; where the tool turns, its weight stays in the "
            "contact wrench"
        )
        findings.append(Finding("gravity-not-compensated", "warning", text, "wrench"))
        return load, "not compensated"
    assert tcp is not None
    findings.extend(_assumed(description))
    stale = without_pose(tcp, wrench.t_ns)
    if stale.any():
        text = (
            f"wrench: {int(stale.sum())} of {len(stale)} samples have no tcp pose near their time, so that the tool's "
            "weight is not known there; the contact wrench is NaN there"
        )
        start, end = (int(moment) for moment in wrench.t_ns[stale][[0, -1]])
        count = int(stale.sum())
        findings.append(Finding("weight-unknown", "warning", text, "wrench", start_ns=start, end_ns=end, count=count))
        weight = np.where(stale[:, None], np.nan, weight)
    return load - weight, "tool weight subtracted, by mass, centre of gravity and pose"


def _assumed(description: LogDescription) -> list[Finding]:
    """What is said where the tool's weight is taken off by something that is not stated."""
    found = []
    if "gravity" not in description.wrench:
        text = "wrench: whether the tool's weight is in it is not stated; included assumed, and taken off"
        found.append(Finding("gravity-assumed", "warning", text, "wrench"))
    if "centre_of_gravity" not in description.robot["tool"]:
        text = "wrench: the tool's centre of gravity is not stated; the tcp origin assumed, so torques may be off"
        found.append(Finding("centre-of-gravity-assumed", "warning", text, "wrench"))
    return found


def _in_gel_frame(description: LogDescription, load: np.ndarray, findings: list[Finding]) -> tuple[np.ndarray, str]:
    """The opposite of the load on the tool, in the gel frame where the transforms are stated."""
    tcp_from_gel, tcp_from_ft = description.transform("tcp_from_gel"), description.transform("tcp_from_ft")
    if tcp_from_gel is None or tcp_from_ft is None:
        text = (
            "wrench: robot.tcp_from_gel or robot.tcp_from_ft is not stated; the contact wrench stays in the ft frame, "
            "torque about the ft origin. Its norm is right, its direction is not that of the gel"
        )
        findings.append(Finding("frame-unknown", "warning", text, "wrench"))
        return -load, "ft"
    gel_from_ft = tcp_from_gel.inverse() @ tcp_from_ft
    return move_wrench(-load, gel_from_ft.matrix), "gel"


def _stored(wrench: StoredSignal, values: np.ndarray, frame: str, gravity: str, zero: Zero) -> StoredSignal:
    columns = SIGNAL_COLUMNS["contact_wrench"]
    attributes = {
        **wrench.attributes,
        "derived_from": "wrench",
        "meaning": "what the gel exerts on the indenter; pressing gives fz > 0 in the gel frame",
        "torque_about": f"origin of the {frame} frame",
        "gravity": gravity,
        "zero": zero.method,
        "noise_n": round(zero.noise, 4),
    }
    return StoredSignal(wrench.t_ns, values, columns, signal_units(columns), frame, wrench.stamps, attributes)
