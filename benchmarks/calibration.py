"""Calibration: seeds end to end, and coverage of the 95 % intervals on surrogate data.

    python benchmarks/calibration.py [--quick] [--seeds 20] [--draws 200] [--fidelity linear|finite-strain] [--low]
                                     [--all-plays] [--uncorrected] [--workers 2]

Every seed draws its own touches, truth, offsets, zeros and noise; the engine itself plays the truth, so what is
measured is the statistics and the interpolation, not the distance of the engine from a real gel. Without ``--low`` the
pad is a coarse one of 143 surface nodes. Plays are kept in TACTILEDATA_CACHE.

With ``--all-plays`` every play that the calibration estimates is made as well, and the same touches are fitted again:
by how much E, nu and mu move, in widths of their 95 % intervals. With ``--uncorrected`` each seed is also fitted
without the correction by plays at the optimum: errors of both ways in standard errors, about quarters of an interval.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from tactiledata.calibrate.calibrate import Calibration, calibrate_measured
from tactiledata.calibrate.corrected_fit import corrected_fit
from tactiledata.calibrate.coverage import coverage
from tactiledata.calibrate.experiment import Experiment, assemble
from tactiledata.calibrate.fit import Fit, fit, vector_loss
from tactiledata.calibrate.measured import Measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.plays.player import play_at, play_plan, play_plan_beside
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute import make_scheduler
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.mesh.structured_pad import GridPlan, pad_mesh, structured_pad
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.sensors.digit import DIGIT

COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
NOISE = WrenchNoise(np.diag([0.1**2] * 3 + [0.005**2] * 3), 1.0, "planted")
OFFSET = 3e-5
FREE_SAMPLES = 40
FRAMES = 10


def touches(chance: np.random.Generator, count: int) -> list[MeasuredTouch]:
    """Spheres and flat punches, pressed and sheared."""
    half = FRAMES // 2
    made = []
    for k in range(count):
        poses = np.tile(np.eye(4), (FRAMES, 1, 1))
        depth = chance.uniform(0.4e-3, 1.0e-3)
        poses[:, :2, 3] = chance.uniform(-2.5e-3, 2.5e-3, 2)
        poses[:, 2, 3] = -depth * np.concatenate([np.linspace(-0.1, 1, half), np.ones(FRAMES - half)])
        way = chance.uniform(5e-4, 15e-4) * np.linspace(0.2, 1, FRAMES - half)
        angle = chance.uniform(0, 2 * np.pi)
        poses[half:, 0, 3] += way * np.cos(angle)
        poses[half:, 1, 3] += way * np.sin(angle)
        solid = [Sphere(radius=0.003), Sphere(radius=0.005), CylinderFlat(radius=0.003)][k % 3]
        empty = np.zeros((FRAMES, 6))
        seconds = np.arange(FRAMES) / 10
        made.append(MeasuredTouch(f"u{k}", f"t{k}", "D1", solid.shape, GelTouch(solid, poses), empty, seconds, 40.0))
    return made


def world(seed: int, count: int, mesh, fidelity) -> tuple[Measured, np.ndarray]:
    """What was measured, and the truth."""
    chance = np.random.default_rng([seed, 7])
    truth = np.array([chance.uniform(860e3, 945e3), chance.uniform(0.46, 0.488), chance.uniform(0.6, 0.9)])
    planned = touches(chance, count)
    plays = play_at(mesh, fidelity, planned, truth[1], truth[2], chance.normal(0, OFFSET, count))
    full = []
    for touch, play in zip(planned, plays, strict=True):
        zero = np.sqrt(np.pi / 2 / FREE_SAMPLES) * chance.standard_normal(6)
        noise = (chance.standard_normal((FRAMES, 6)) + zero) * NOISE.deviations
        full.append(MeasuredTouch(**{**vars(touch), "wrench": truth[0] * play.wrench + noise}))
    return Measured(tuple(full), mesh, {}, NOISE, {}), truth


def moved_by_estimates(done: Calibration) -> str:
    """Return a sentence on how far E, nu and mu move if no play is estimated, in per cent and in interval widths."""
    began = time.perf_counter()
    plan = ResponsePlan.of(done.bounds)
    touches, options = done.measured.touches, done.options
    plays, _ = play_plan_beside(done.measured.mesh, options.mechanics, touches, plan, (), estimates="none")
    spent = time.perf_counter() - began
    experiment = assemble(touches, plan, plays.by_node())
    assert isinstance(experiment, Experiment), "a touch cannot be solved for"
    all_made = corrected_fit(experiment, done.measured, done.bounds, options, make_scheduler(options.workers, None)).fit
    moved = done.fit.parameters - all_made.parameters
    widths = [np.diff(ends, axis=1)[:, 0] for ends in (all_made.intervals.ends, all_made.simulation_error.ends)]
    shown = [", ".join(f"{value:+.3f}" for value in row) for row in (moved / widths[0], moved / widths[1])]
    percent = ", ".join(f"{100 * value:+.2f} %" for value in moved / all_made.parameters)
    return (
        f"estimated less all plays: E, nu, mu {percent}; in widths of the intervals {shown[0]}; of those with"
        f" simulation error {shown[1]}; all plays took {spent:.1f} s"
    )


def uncorrected(done: Calibration) -> Fit:
    """Return the fit of the same touches whose interpolated forces are not corrected by plays at the optimum."""
    plan = ResponsePlan.of(done.bounds)
    touches, options = done.measured.touches, done.options
    experiment = assemble(touches, plan, play_plan(done.measured.mesh, options.mechanics, touches, plan).by_node())
    assert isinstance(experiment, Experiment), "a touch cannot be solved for"
    return fit(experiment, done.measured.noise, done.bounds, options)


def in_standard_errors(found: Fit, truth: np.ndarray) -> np.ndarray:
    """Return the errors (3,) of E, nu and mu over a quarter of their 95 % intervals."""
    return (found.parameters - truth) / (np.diff(found.intervals.ends, axis=1)[:, 0] / (2 * 1.96))


def main() -> None:
    """Print errors by seed, then coverage."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--trajectories", type=int, default=25)
    parser.add_argument("--fidelity", default="linear")
    parser.add_argument("--low", action="store_true", help="the low-resolution pad instead of the coarse one")
    parser.add_argument("--workers", type=int, default=1, help="processes that simulate")
    parser.add_argument("--all-plays", action="store_true", help="fit again with every play made")
    parser.add_argument("--uncorrected", action="store_true", help="fit without the correction as well")
    asked = parser.parse_args()
    seeds, draws, count = (2, 3, 8) if asked.quick else (asked.seeds, asked.draws, asked.trajectories)
    mesh = pad_mesh("digit", DIGIT.gel) if asked.low else structured_pad("digit-coarse", DIGIT.gel, COARSE)
    print(f"{count} trajectories of {FRAMES} frames, {asked.fidelity}, pad {mesh.name} ({len(mesh.vertices)} vertices)")
    errors, held, runs = [], [], []
    for seed in range(seeds):
        measured, truth = world(seed, count, mesh, asked.fidelity)
        row = []
        for loss in ("vector", "norm"):
            options = CalibrationOptions(
                loss=loss, fidelity=asked.fidelity, hold_out=0.0, seed=seed, workers=asked.workers
            )
            began = time.perf_counter()
            done = calibrate_measured(measured, options, "0" * 64)
            row.append(done.fit.parameters / truth - 1)
            ends = done.fit.intervals.ends
            if loss == "vector":
                held.append((ends[:, 0] <= truth) & (truth <= ends[:, 1]))
                spent = time.perf_counter() - began
                runs.append((done, truth))
        errors.append(row)
        words = "; ".join(
            f"{name} E {100 * e[0]:+.2f} % nu {100 * e[1]:+.2f} % mu {100 * e[2]:+.2f} %"
            for name, e in zip(("vector", "norm"), row, strict=True)
        )
        print(f"seed {seed}: {words}; covered {held[-1].tolist()}; {spent:.1f} s", flush=True)
        if asked.all_plays:
            print(f"seed {seed}: {moved_by_estimates(runs[-1][0])}", flush=True)
    table = 100 * np.abs(np.array(errors))
    for k, name in enumerate(("vector", "norm")):
        print(f"{name}: |error| median, largest, %: {np.median(table[:, k], axis=0)}, {table[:, k].max(axis=0)}")
    print(f"95 % intervals that hold the truth: {np.mean(held, axis=0)}")
    if asked.uncorrected:
        ways = {
            "corrected": [done.fit for done, _ in runs],
            "without correction": [uncorrected(done) for done, _ in runs],
        }
        for words, fits in ways.items():
            off = np.array([in_standard_errors(one, truth) for one, (_, truth) in zip(fits, runs, strict=True)])
            rms, mean = np.sqrt(np.mean(off**2, axis=0)).round(2), off.mean(axis=0).round(2)
            held_by = np.mean(np.abs(off) <= 1.96, axis=0).round(2)
            print(f"{words}: errors in standard errors, rms {rms}, mean {mean}; within 1.96: {held_by}")
    done, truth = runs[0]
    began = time.perf_counter()
    loss = vector_loss(done.experiment, NOISE, done.fit.fitted, 4e-5, done.options.shape_share)
    share = coverage(loss, done.bounds, truth, draws).share
    print(f"coverage on {draws} surrogates of E, nu, mu: {share}; {time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
