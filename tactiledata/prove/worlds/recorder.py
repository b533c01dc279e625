"""Worlds of a plan recorded by a generator, and what a diagnosis reads of their readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.calibrate.measured import stated_noise
from tactiledata.calibrate.touches import ForceReadings
from tactiledata.contract.take import StoredSignal
from tactiledata.diagnose.touches.rest_means import FrameWrenches, means_at_rest, rest_spans
from tactiledata.diagnose.touches.touch_case import BaseFamily, TouchCase, TouchSet
from tactiledata.diagnose.zeros.coarse_steps import find_coarse_steps
from tactiledata.diagnose.zeros.dead_band import find_dead_band
from tactiledata.diagnose.zeros.inertia import FreeAirMoves, find_inertia
from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.effects.touch.felt_acceleration import felt_accelerations
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.ingest.clocks.align import align, fractions_between
from tactiledata.ingest.forces.contact import contact_wrench
from tactiledata.ingest.forces.onset import surely_free
from tactiledata.nuisance.noise import noise_at_rest
from tactiledata.prove.worlds.logs import LogReadings, WorldLog, play_logs, stored_signal, unfelt
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.touches import Way, frame_times, is_clear, motion_until, part_of, told_touches, way_of
from tactiledata.prove.worlds.zeros import zeros_of
from tactiledata.rig.bank.bank import ContactBank
from tactiledata.rig.hidden.base import HiddenEffect
from tactiledata.rig.play import SolveContact
from tactiledata.rig.scenario.scenario import load_scenario


@dataclass(frozen=True)
class ReadWorld:
    """What a diagnosis reads of a world, for each of its touches.

    Parameters
    ----------
    at_frames : list of FrameWrenches
        Contact wrenches at the frames, averaged where the tip stands.
    interpolated : list of (n, 6), N and N m
        The same, interpolated between two readings.
    free : list of (m, 6), N and N m
        Samples in free air before the touch.
    fractions : (f,)
        Where all frames lie between two samples.
    zeros : ForceZeros
        The zeros of all touches.
    shown : tuple of str
        Effects that readings show by themselves.
    dead_band : float
        Half width, N, of the dead-band that the forces show; 0 where they show none.
    """

    at_frames: list[FrameWrenches]
    interpolated: list[Array]
    free: list[Array]
    fractions: Array
    zeros: ForceZeros
    shown: tuple[str, ...] = ()
    dead_band: float = 0.0

    @property
    def wrenches(self) -> list[Array]:
        """Wrenches (n, 6) of each touch, N and N m, averaged where the tip stands."""
        return [one.wrench for one in self.at_frames]


@dataclass(frozen=True)
class WorldMaker:
    """Records worlds of a plan, and reads recordings as a diagnosis does.

    `readings` is the generator's side: it knows what is hidden. `observed` and `cases` are the diagnosis's side: they
    know the plan and the readings.

    Parameters
    ----------
    plan : WorldPlan
        What the arm is told.
    bank : ContactBank
        Kept solutions of the rig's layer solver.
    logs : list of WorldLog
        The touches laid out, without forces.
    touches : list of Touch
        The touches as the logs tell them.
    rows : list of (n,) bool
        Frames of each that are used.
    ways : list of Way
        Ways of the tip at the rate of the stream of poses.
    solve : callable, optional
        The contact of a touch; the bank's where ``None``.
    noise : float
        Factor on noise and quanta of the force sensor.
    """

    plan: WorldPlan
    bank: ContactBank
    logs: list[WorldLog]
    touches: list[Touch]
    rows: list[Mask]
    ways: list[Way]
    solve: SolveContact | None = None
    noise: float = 1.0

    @staticmethod
    def of(plan: WorldPlan, folder: Path) -> WorldMaker:
        """Return the maker of a plan; its touches are laid out, and nothing is solved."""
        logs = play_logs(load_scenario(plan.scenario(0, plan.truth, [])), unfelt)
        told = [touch for log in logs for touch in told_touches(log, plan.truth, plan.geometry)]
        rows = [np.ones(len(touch), dtype=bool) for touch in told]
        ways = [way_of(log, *mounted) for log in logs for mounted in log.mounted]
        return WorldMaker(plan, ContactBank(folder, plan.pitch, logs[0].rig_setup.indenters), logs, told, rows, ways)

    def keeping(self, rows: list[Mask]) -> WorldMaker:
        """Return the same with some of the frames: those that the gel engine could solve."""
        return replace(self, touches=[part_of(*pair) for pair in zip(self.touches, rows, strict=True)], rows=rows)

    def readings(
        self,
        seed: int,
        material: GelMaterial,
        hidden: list[dict[str, Any]],
        more: tuple[HiddenEffect, ...] = (),
        is_exact: bool = False,
    ) -> list[LogReadings]:
        """Return what the force sensor reads in each log of a world.

        Parameters
        ----------
        seed : int
            Seed of the world's noise and offsets.
        material : GelMaterial
            The real gel.
        hidden : list of dict
            Hidden effects as a scenario states them.
        more : tuple of HiddenEffect
            Hidden effects that no scenario states.
        is_exact : bool
            Whether the force sensor has neither noise nor quanta.
        """
        noise = 0.0 if is_exact else self.noise
        return [log.readings(noise) for log in self.played(seed, material, hidden, more)]

    def played(
        self, seed: int, material: GelMaterial, hidden: list[dict[str, Any]], more: tuple[HiddenEffect, ...] = ()
    ) -> list[WorldLog]:
        """Return the logs of a world, whose readings may be taken with noise and without.

        Parameters
        ----------
        seed, material, hidden, more
            See `readings`.
        """
        scenario = load_scenario(self.plan.scenario(seed, material, hidden))
        scenario = replace(scenario, hidden=(*scenario.hidden, *more))
        return play_logs(scenario, self.solve or self.bank.contact)

    def recorded(
        self,
        seed: int,
        material: GelMaterial,
        hidden: list[dict[str, Any]],
        more: tuple[HiddenEffect, ...] = (),
        is_exact: bool = False,
    ) -> ReadWorld:
        """Return what a diagnosis reads of a world; the parameters are those of `readings`.

        Parameters
        ----------
        seed, material, hidden, more, is_exact
            See `readings`.
        """
        return self.observed(self.readings(seed, material, hidden, more, is_exact))

    def observed(self, readings: Sequence[LogReadings]) -> ReadWorld:
        """Return what a diagnosis reads of the readings of all logs; the plan is all that it knows beside them."""
        logs = [
            (log, stored_signal("wrench", one.t_ns, one.values, "ft"), log.poses)
            for log, one in zip(self.logs, readings, strict=True)
        ]
        stored = [touch for log in logs for touch in _as_stored(*log)]
        interpolated = [touch.wrench[rows] for touch, rows in zip(stored, self.rows, strict=True)]
        at_frames = [
            means_at_rest(touch.seconds, wrench, rest_spans(touch.seconds, *way), one.readings)
            for touch, wrench, way, one in zip(self.touches, interpolated, self.ways, stored, strict=True)
        ]
        fractions = np.concatenate([touch.fractions for touch in stored])
        moves = [
            FreeAirMoves(number, one.readings.seconds[: len(one.free)], one.free[:, :3], felt, np.zeros(felt.shape[1]))
            for number, (one, way) in enumerate(zip(stored, self.ways, strict=True))
            for felt in [felt_accelerations(one.readings.seconds[: len(one.free)], *way)]
        ]
        logged = [wrench.values for _, wrench, _ in logs]
        dead_band = find_dead_band(logged)
        found = dead_band or find_coarse_steps(logged), find_inertia(moves)
        shown = tuple(str(one.document["effect"]) for one in found if one is not None)
        free = [touch.free for touch in stored]
        band = dead_band.force if dead_band else 0.0
        return ReadWorld(at_frames, interpolated, free, fractions, zeros_of(logs), shown, band)

    def cases(self, recorded: ReadWorld, base: BaseFamily) -> TouchSet:
        """Return the trajectories of a world, with their noise as a calibration estimates it."""
        stretches = recorded.free
        steps = np.concatenate([np.diff(touch.seconds) for touch in self.touches])
        noise = noise_at_rest(stretches, max(1, round(100.0 * float(np.median(steps)))), recorded.fractions)
        noise = noise or stated_noise()
        cases = []
        for number, (touch, way, one, free) in enumerate(
            zip(self.touches, self.ways, recorded.at_frames, recorded.free, strict=True)
        ):
            read = replace(touch, seconds=one.seconds, **motion_until(one.seconds, way))
            factors = noise.mean_factors(one.readings)
            cases.append(TouchCase(read, one.wrench, noise, is_clear(read), float(len(free)), f"t{number}", factors))
        return TouchSet(cases, base, self.plan.bounds)


class _StoredTouch(NamedTuple):
    """What a store holds of a touch: wrenches at its frames (n, 6), all readings, those in free air (m, 6), and where
    the frames lie between two readings (f,).
    """

    wrench: Array
    readings: ForceReadings
    free: Array
    fractions: Array


def _as_stored(log: WorldLog, wrench: StoredSignal, tcp: StoredSignal) -> list[_StoredTouch]:
    """Return readings after what a store does with them: weight off, zero of each touch, gel frame, at the frames."""
    played = log.played
    spans = [(play.touch.name, play.start_ns, play.end_ns) for play in played.plays]
    contact = contact_wrench(log.description, wrench, tcp, spans).signal
    found = []
    for play in played.plays:
        rows = slice(*np.searchsorted(contact.t_ns, [play.start_ns, play.end_ns]))
        times = frame_times(play)
        fractions = fractions_between(contact.t_ns[rows], times)
        seconds = np.asarray((contact.t_ns[rows] - played.start_ns) * 1e-9, dtype=float)
        values = np.asarray(contact.values[rows], dtype=float)
        readings = ForceReadings(seconds, values)
        free = values[: surely_free(values, contact.t_ns[rows])]
        found.append(_StoredTouch(align(contact, times).values, readings, free, fractions))
    return found
