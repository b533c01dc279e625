"""The file ``calibration.json`` of a calibration (schemas/calibration.json)."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tactiledata.calibrate.bounds import NAMES
from tactiledata.calibrate.calibrate import Calibration
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.provenance import provenance
from tactiledata.contract.schema import check_document

FORMAT = "tactiledata-calibration/1"


def calibration_document(calibration: Calibration) -> dict[str, Any]:
    """Return the content of ``calibration.json``; it is the same for the same store, options and engine."""
    fit, measured, options = calibration.fit, calibration.measured, calibration.options
    assert measured.mesh is not None
    touches = calibration.experiment.touches
    document = {
        "format": FORMAT,
        **_by_name(fit.parameters),
        "intervals": _intervals(calibration),
        "known": {name: known.document for name, known in calibration.known.items()},
        "correlation": [[float(value) for value in row] for row in fit.intervals.correlation],
        "bounds": {
            "name": calibration.bounds.name,
            **{name: [low, high] for name, low, high in calibration.bounds},
        },
        "start": _by_name(fit.start),
        "loss": options.loss,
        "losses": {
            name: {part: _number(value) for part, value in asdict(values).items()}
            for name, values in fit.losses.items()
        },
        "offsets": {touch.uid: float(offset) for touch, offset in zip(touches, fit.offsets, strict=True)},
        "shape_error": options.shape_share,
        "shape_factors": fit.shape_factors,
        "trajectories": {
            "fitted": [touches[place].uid for place in fit.fitted],
            "held_out": [touches[place].uid for place in fit.held_out],
            "left_out": {**measured.left_out, **calibration.experiment.left_out},
            "frames": len(calibration.experiment.measured),
        },
        "simulated_recordings": calibration.simulated.document(),
        "noise": {
            "source": measured.noise.source,
            "deviations": measured.noise.deviations.tolist(),
            "inflation": measured.noise.inflation,
        },
        "engine": options.engine,
        "fidelity": options.fidelity,
        "mesh": {"name": measured.mesh.name, "sha256": measured.mesh.digest},
        "interpolation_error": {
            "rms": _number(calibration.interpolation_error[0]),
            "largest": _number(calibration.interpolation_error[1]),
        },
        "findings": [
            {"code": finding.code, "severity": finding.severity, "message": finding.message}
            for finding in calibration.findings
        ],
        "provenance": provenance("calibrate", {"store": calibration.store}, options.document()),
    }
    check_document(document, "calibration", "the calibration")
    return document


def write_calibration(calibration: Calibration, path: Path) -> dict[str, Any]:
    """Write ``calibration.json`` atomically to a path, and return its content."""
    document = calibration_document(calibration)
    write_json_atomic(path, document)
    return document


def _by_name(values: Any) -> dict[str, float]:
    """Values of E, nu and mu (3,) under the names of the parameters."""
    return {name: float(value) for name, value in zip(NAMES, values, strict=True)}


def _intervals(calibration: Calibration) -> dict[str, Any]:
    """Return the 95 % intervals with and without the simulation's own errors, as JSON values."""
    known, options, erring = calibration.fit.intervals, calibration.options, calibration.fit.simulation_error
    return {
        "method": "profile likelihood" if options.loss == "vector" else "bootstrap over trajectories",
        "inflation": known.inflation.tolist(),
        "with_simulation_error": {
            "force_error": erring.force,
            "law_error": erring.law,
            **{name: ends.tolist() for name, ends in zip(NAMES, erring.ends, strict=True)},
        },
        **{
            name: {
                "low": float(ends[0]),
                "high": float(ends[1]),
                "low_is_bound": bool(is_open[0]),
                "high_is_bound": bool(is_open[1]),
            }
            for name, ends, is_open in zip(NAMES, known.ends, known.is_open, strict=True)
        },
    }


def _number(value: float) -> float | None:
    """Return the value, or ``None`` where it is not finite, which JSON cannot write."""
    return float(value) if math.isfinite(value) else None
