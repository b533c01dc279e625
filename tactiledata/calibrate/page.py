"""The HTML page of a calibration: result, losses, findings, measured and simulated forces, loss around the optimum."""

from __future__ import annotations

import numpy as np

from tactiledata.calibrate.bounds import NAMES, SYMBOLS
from tactiledata.calibrate.calibrate import Calibration
from tactiledata.calibrate.fit import norm_loss, vector_loss
from tactiledata.calibrate.losses import Loss
from tactiledata.calibrate.remarks import in_words
from tactiledata.calibrate.surface import loss_surface
from tactiledata.contract.wording import counted
from tactiledata.report.calibration_plots import LossSurface, Overlay, draw_overlays, draw_residuals, draw_surfaces
from tactiledata.report.page import Picture, Section, render_page
from tactiledata.report.plots import png_bytes

MOST_OVERLAYS = 12
"""Most trajectories whose measured and simulated forces are drawn."""
LABELS = {"youngs_modulus": "E, kPa", "poisson_ratio": "nu", "friction": "mu"}


def calibration_page(calibration: Calibration) -> str:
    """Return the page of a calibration as HTML."""
    options, experiment = calibration.options, calibration.experiment
    fit = calibration.fit
    sentences = [
        f"{counted(len(fit.fitted), 'trajectory')} fitted, {len(fit.held_out)} held out, "
        f"{counted(len(experiment.measured), 'frame')}; loss {options.loss}, "
        f"engine {options.engine}, fidelity {options.fidelity}"
        + (" (a preview: its forces are 10 to 20 % low at 1 mm)" if options.fidelity == "linear" else "")
        + (" (for comparison: its forces are too high)" if options.engine == "mujoco-flex" else "")
        + ".",
    ]
    sections = [_result(calibration), _losses(calibration), _remarks(calibration)]
    sections += [_overlays(calibration), _surfaces(calibration), _residuals(calibration)]
    return render_page(
        "Calibration of the gel", sentences, sections, f"store {calibration.store[:16]}", calibration.simulated
    )


def result_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """One row of texts per parameter: symbol, value, 95 % interval, interval with simulation error, start, verdict."""
    fit = calibration.fit
    rows: list[tuple[str, ...]] = []
    for k, name in enumerate(NAMES):
        ends = [
            in_words(name, float(end)) + (" (bound)" if is_open else "")
            for end, is_open in zip(fit.intervals.ends[k], fit.intervals.is_open[k], strict=True)
        ]
        value, start = in_words(name, float(fit.parameters[k])), in_words(name, float(fit.start[k]))
        with_simulation_error = " to ".join(in_words(name, float(end)) for end in fit.simulation_error.ends[k])
        rows.append(
            (SYMBOLS[name], value, " to ".join(ends), with_simulation_error, start, calibration.known[name].verdict)
        )
    return rows


def loss_rows(calibration: Calibration) -> list[tuple[str, ...]]:
    """One row of texts per loss: name and unit, at the start, at the optimum, held out at both."""
    units = {"vector": "times the noise", "norm": "N"}
    return [
        (f"{name} ({units[name]})", *(f"{value:.3f}" if np.isfinite(value) else "-" for value in vars(values).values()))
        for name, values in calibration.fit.losses.items()
    ]


def _result(calibration: Calibration) -> Section:
    """Section with the parameters' table and the sentences on interpolation and simulation errors."""
    rms, largest = calibration.interpolation_error
    text = (
        f"Forces interpolated in the grid of responses differ by {rms:.3f} N rms, {largest:.3f} N at most, from those "
        "played at the optimum."
    )
    if calibration.fit.shape_factors:
        parts = [f"{name} {factor:.3f}" for name, factor in calibration.fit.shape_factors.items()]
        text += " Measured over simulated force, by indenter: " + ", ".join(parts) + "."
    errors = calibration.fit.simulation_error
    text += (
        f" With simulation error: two simulations of one gel differ by {100 * errors.force:.0f} % in all forces alike "
        f"and by {100 * errors.law:.0f} % in how forces grow over a factor e."
    )
    columns = ("", "value", "95 % interval", "with simulation error", "start", "verdict")
    return Section("Result", [("info", text)], columns, result_rows(calibration))


def _losses(calibration: Calibration) -> Section:
    """Section with the table of losses."""
    columns = ("loss", "start", "fitted", "held out, start", "held out")
    return Section("Losses", (), columns, loss_rows(calibration))


def _remarks(calibration: Calibration) -> Section:
    """Section with the findings, or a sentence that there are none."""
    sentences = [(finding.severity, f"{finding.message} [{finding.code}]") for finding in calibration.findings]
    return Section("What to know", sentences or [("", "Nothing stands out.")])


def _overlays(calibration: Calibration) -> Section:
    """Section with measured and simulated forces over time; held-out trajectories come first."""
    experiment, fit = calibration.experiment, calibration.fit
    held_out = set(fit.held_out.tolist())
    order = sorted(range(len(experiment.touches)), key=lambda place: (place not in held_out, place))[:MOST_OVERLAYS]
    overlays = []
    for place in order:
        touch, start = experiment.touches[place], experiment.response.starts[place]
        rows = slice(start, start + experiment.response.counts[place])
        overlays.append(
            Overlay(
                f"{touch.name} {touch.indenter}" + (" (held out)" if place in held_out else ""),
                touch.seconds[experiment.frames[place]],
                experiment.measured[rows, :3],
                calibration.played[rows, :3],
            )
        )
    png = png_bytes(draw_overlays(overlays), heading=calibration.simulated.heading)
    picture = Picture(png, "Dots: measured. Lines: simulated at the optimum.")
    return Section("Measured and simulated", pictures=[picture])


def _surfaces(calibration: Calibration) -> Section:
    """Section with the loss over E and nu, and over E and mu, the third parameter at its optimum."""
    fit, bounds, options = calibration.fit, calibration.bounds, calibration.options
    loss: Loss
    if options.loss == "vector":
        loss = vector_loss(
            calibration.experiment, calibration.measured.noise, fit.fitted, options.offset_prior, options.shape_share
        )
    else:
        loss = norm_loss(calibration.experiment, fit.fitted)
    surfaces = []
    # E lies on the horizontal axis, in kPa; nu or mu on the vertical one
    for up in (1, 2):
        x, y, values = loss_surface(loss, bounds, fit.parameters, 0, up)
        best = (float(fit.parameters[0]) / 1e3, float(fit.parameters[up]))
        names = (LABELS[NAMES[0]], LABELS[NAMES[up]])
        title = f"{options.loss} loss, {SYMBOLS[NAMES[3 - up]]} at its optimum"
        surfaces.append(LossSurface(title, *names, x / 1e3, y, values, best, float("nan")))
    picture = Picture(png_bytes(draw_surfaces(surfaces)), "The loss inside the bounds; the cross is the optimum.")
    return Section("The loss around its optimum", pictures=[picture])


def _residuals(calibration: Calibration) -> Section:
    """Section with the residual forces of all frames."""
    measured = calibration.experiment.measured
    figure = draw_residuals(measured[:, 2], (measured - calibration.played)[:, :3], ("fx", "fy", "fz"))
    png = png_bytes(figure, heading=calibration.simulated.heading)
    return Section("What is left", pictures=[Picture(png, "Residual forces of all frames.")])
