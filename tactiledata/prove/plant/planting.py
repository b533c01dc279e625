"""A copy of a store with an effect planted: readings are changed, and all that follows from them is derived anew."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from tactiledata.arrays import Array
from tactiledata.contract.description import LogDescription
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.records import Finding
from tactiledata.contract.take import StoredSignal, Take, findings_table
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.ingest.clocks.align import align
from tactiledata.ingest.forces.contact import contact_wrench
from tactiledata.prove.plant.effects import NOTHING, PlantedReadings, find_plant, stated_thicker
from tactiledata.store.change.merge import merge
from tactiledata.store.read.reader import Store

WRENCH, CONTACT = "wrench", "contact_wrench"
"""Streams of the readings, and of what is derived from them."""


@dataclass(frozen=True)
class Planting:
    """What is planted.

    Parameters
    ----------
    effect : str
        Name of the effect, or ``NOTHING``.
    size : float
        Its size, in the effect's unit; 0 where nothing is planted.
    seed : int
        Seed of directions.
    """

    effect: str
    size: float
    seed: int

    def sealed_take(self, take: Take, commitment: str) -> Take:
        """Return a recording with the effect in it, and with a finding that says so without saying what it is.

        Parameters
        ----------
        take : Take
            The recording.
        commitment : str
            Commitment to the label.
        """
        finding = Finding(
            "effect-planted",
            "info",
            f"an effect was planted into this copy, or nothing; its label is sealed as {commitment}",
        )
        changed = self.take(take)
        return replace(changed, findings=pa.concat_tables([changed.findings, findings_table([finding])]))

    def take(self, take: Take) -> Take:
        """Return a recording of a store with the effect in it; one without readings of a force sensor as it is.

        Raises
        ------
        UsageError
            The recording lacks what the effect needs.
        """
        if self.effect == NOTHING:
            return take
        plant = find_plant(self.effect)
        if plant.change is None:
            return self._stated(take)
        if WRENCH not in take.signals or CONTACT not in take.aligned:
            return take
        description = LogDescription(dict(take.description))
        readings = PlantedReadings.of(take.signals[WRENCH], take.signals.get("tcp"), description)
        # a direction is one of the rig, the same in all of its recordings
        values = plant.change(readings, self.size, np.random.default_rng(self.seed))
        return with_readings(take, values)

    def _stated(self, take: Take) -> Take:
        """Return a recording that states its gel otherwise."""
        sensors = {serial: stated_thicker(facts, self.size) for serial, facts in take.sensors.items()}
        if sensors == dict(take.sensors):
            raise UsageError(
                f"{take.source.key} does not state the thickness of its gel",
                "a thickness that can be relabelled",
                "Plant another effect.",
            )
        return replace(take, sensors=sensors, description=stated_thicker(take.description, self.size))


def with_readings(take: Take, values: Array) -> Take:
    """Return a recording with other readings of the force sensor (n, 6), and all that follows from them.

    Derived anew are the contact wrench with its zeros, the values at the frames, and contact and peak forces.

    Parameters
    ----------
    take : Take
        The recording.
    values : (n, 6), N and N m
        Readings in place of those that it has.
    """
    wrench = replace(take.signals[WRENCH], values=values)
    names, starts, stops = (take.trajectories[name].to_pylist() for name in ("trajectory", "start_ns", "end_ns"))
    spans = list(zip(names, starts, stops, strict=True))
    contact = contact_wrench(LogDescription(dict(take.description)), wrench, take.signals.get("tcp"), spans).signal
    signals = {**take.signals, WRENCH: wrench, CONTACT: contact}
    t_ns = take.frames["t_ns"].to_numpy()
    aligned = dict(take.aligned)
    for name in (WRENCH, CONTACT):
        if name in aligned:
            fresh = align(signals[name], t_ns)
            # a frame that had no value, since its time is off, has none now
            gone = take.aligned[name].gap_ns < 0
            fresh.values[gone], fresh.gap_ns[gone] = np.nan, -1
            aligned[name] = fresh
    force = np.linalg.norm(aligned[CONTACT].values[:, :3], axis=1).astype(np.float32)
    frames = take.frames.set_column(
        take.frames.schema.get_field_index("contact_force"), take.frames.schema.field("contact_force"), pa.array(force)
    )
    return replace(take, signals=signals, aligned=aligned, frames=frames, trajectories=_peaks(take, contact, spans))


def _peaks(take: Take, contact: StoredSignal, spans: list[tuple[str, int, int]]) -> pa.Table:
    """Return the table of trajectories with the peak forces of other contact wrenches."""
    norms = np.linalg.norm(contact.values[:, :3], axis=1)
    peaks = []
    for _, start, stop in spans:
        inside = norms[slice(*np.searchsorted(contact.t_ns, [start, stop]))]
        known = inside[np.isfinite(inside)]
        peaks.append(float(known.max()) if len(known) else float("nan"))
    place = take.trajectories.schema.get_field_index("peak_force")
    return take.trajectories.set_column(place, take.trajectories.schema.field(place), pa.array(peaks, pa.float32()))


def plant_into(
    store: Store, into: Path, planting: Planting, commitment: str, progress: Progress = no_progress
) -> list[str]:
    """Copy a store with an effect planted into all of its recordings; return what is worth saying, in sentences.

    Killed and called again with the same planting, it goes on.

    Parameters
    ----------
    store : Store
        The store; it stays as it is.
    into : Path
        Where the copy is written.
    planting : Planting
        What is planted.
    commitment : str
        Commitment to the label; the copy states it.
    progress : Progress
        Called with how many recordings are done.

    Raises
    ------
    UsageError
        The recordings lack what the effect needs.
    """
    need_readings(store)
    findings = merge([store], into, progress, partial(planting.sealed_take, commitment=commitment))
    n_frames = Store.open(into).n_frames
    if n_frames != store.n_frames:
        raise TactileDataError(f"the copy has {n_frames} frames", f"{store.n_frames}, as the store has")
    return [one.message for one in findings]


def need_readings(store: Store) -> None:
    """Refuse a store into which nothing can be planted.

    Raises
    ------
    UsageError
        It has no readings of a force sensor, or no contact wrench.
    """
    if WRENCH not in store.signal_names or CONTACT not in store.signal_names:
        raise UsageError(
            f"{store.location} has no readings of a force sensor",
            f"the streams {WRENCH} and {CONTACT}",
            "Ingest recordings with forces.",
        )
