"""What is said of a fit: each sentence where it holds, and not where it does not."""

from dataclasses import replace

import numpy as np
import pytest
from closed_form import FRAMES, NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.fit import fit
from tactiledata.calibrate.intervals import Intervals
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.remarks import remarks

pytestmark = pytest.mark.slow

WIDE = find_bounds("wide")
PAPER = find_bounds("paper")


@pytest.fixture(scope="module")
def world():
    return ClosedFormWorld()


def said(world, measured, bounds=WIDE, **options):
    chosen = CalibrationOptions(bounds=bounds.name, **{"shape_error": 0.0, **options})
    found = fit(world.experiment(measured, bounds.name), NOISE, bounds, chosen)
    return by_code(remarks(found, bounds, 4e-5, {}, True, chosen.shape_share)), found


def by_code(findings):
    together = {}
    for finding in findings:
        together[finding.code] = together.get(finding.code, "") + finding.message + "\n"
    return together


def test_nothing_is_said_of_a_sound_fit(world):
    """No remark is made of a truth well inside the bounds with enough touches that slip."""
    found, _ = said(world, world.measured(offsets=np.random.default_rng(0).normal(0, 3e-5, world.count)))
    assert not set(found) - {"calibration-unidentified"}
    assert "E cannot" not in found.get("calibration-unidentified", "")


@pytest.mark.parametrize(
    ("sensors", "is_said"), [((), False), (("D2",), False), (("D2", "D1"), True), (tuple("abcde"), True)]
)
def test_gels_that_are_fitted_as_one_are_counted(world, sensors, is_said):
    """The sensors are named where there are several, and nothing is said of one."""
    _, found = said(world, world.measured())
    told = by_code(remarks(found, WIDE, 4e-5, {}, True, sensors=sensors)).get("calibration-one-gel", "")
    assert bool(told) == is_said
    named = {"": "", "D2D1": "2 sensors (D1, D2)", "abcde": "5 sensors (a, b, c, d, ...)"}
    assert named.get("".join(sensors), "") in told


def test_a_bound_hit_is_called_a_symptom(world):
    """A gel softer than the paper's bounds pins E below; inside wide bounds it does not."""
    measured = world.measured(truth=TRUTH * [0.85, 1, 1])
    found, _ = said(world, measured, PAPER)
    assert "E stands at its lower bound, 838.0 kPa" in found["calibration-bound"]
    assert "symptom" in found["calibration-bound"]
    assert "Compare --bounds wide" in found["calibration-bound"]
    assert "calibration-bound" not in said(world, measured)[0]


def test_wider_bounds_are_advised_only_where_there_are_any(world):
    """The warning about a parameter at the end of the widest bounds names the diagnosis in place of wider bounds."""
    shares = np.array([0.5, 0.0, 0.5])
    _, found = said(world, world.measured())
    at_end = by_code(remarks(replace(found, parameters=PAPER.scaled(shares)), PAPER, 4e-5, {}, True))
    assert "nu stands at its lower bound" in at_end["calibration-bound"]
    assert "No bounds go farther" in at_end["calibration-bound"]
    assert "--bounds wide" not in at_end["calibration-bound"]


def test_friction_cannot_be_known_without_slip():
    """Touches without shear tell nothing of mu; sheared ones do."""
    still, sheared = ClosedFormWorld(shear=1e-6), ClosedFormWorld()
    assert "mu cannot be known" in said(still, still.measured())[0]["calibration-unidentified"]
    assert "mu cannot" not in said(sheared, sheared.measured())[0].get("calibration-unidentified", "")


@pytest.mark.parametrize(("together", "is_said"), [(-0.97, True), (0.96, True), (0.90, False), (-0.2, False)])
def test_a_singular_pair_is_named(world, together, is_said):
    """E and nu, which the pad's thickness imitates; a weaker correlation is not singular."""
    _, found = said(world, world.measured())
    correlation = np.eye(3)
    correlation[0, 1] = correlation[1, 0] = together
    known = found.intervals
    pinned = replace(found, intervals=Intervals(known.ends, known.is_open, correlation, known.inflation))
    found_codes = by_code(remarks(pinned, WIDE, 4e-5, {}, True))
    assert ("calibration-singular" in found_codes) == is_said
    if is_said:
        assert "E and nu are a singular pair" in found_codes["calibration-singular"]
        assert "thickness" in found_codes["calibration-singular"]


def test_one_radius_makes_a_singular_pair_of_its_own():
    """Spheres of one size at one depth fix a combination of E and nu only; several sizes and depths part them."""
    world = ClosedFormWorld(30)
    world.radius[:] = 4e-3
    world.depth[:] = 0.8e-3 * np.concatenate([np.linspace(-0.1, 1, FRAMES // 2), np.ones(FRAMES - FRAMES // 2)])
    _, alike = said(world, world.measured())
    several = ClosedFormWorld(30)
    _, apart = said(several, several.measured())
    one, other = (abs(found.intervals.correlation[0, 1]) for found in (alike, apart))
    assert one > other


def test_a_misfit_is_said(world):
    """Forces that the model cannot give: turned by 46 degrees."""
    turn = np.array([[np.cos(0.8), -np.sin(0.8), 0], [np.sin(0.8), np.cos(0.8), 0], [0, 0, 1]])
    measured = world.measured()
    turned = np.hstack([measured[:, :3] @ turn.T, measured[:, 3:] @ turn.T])
    assert "times the noise" in said(world, turned)[0]["calibration-misfit"]


def test_a_common_offset_and_a_far_one_are_said(world):
    """A shift of all poses is said, and so is one trajectory whose tip slipped in its holder."""
    common, _ = said(world, world.measured(offsets=8e-5))
    assert "share +0.0" in common["calibration-common-offset"]
    far = np.zeros(world.count)
    far[3] = 1.8e-4
    single, _ = said(world, world.measured(offsets=far))
    assert "1 trajectory of 20" in single["calibration-offset"]
    assert "calibration-common-offset" not in single


def test_reasons_for_leaving_out_are_counted(world):
    """A reason for leaving trajectories out is reported with their number."""
    _, found = said(world, world.measured())
    findings = remarks(found, WIDE, 4e-5, {"no force: the sensor felt less than 1 N": 3}, True)
    assert any("3 trajectories left out: no force" in finding.message for finding in findings)


def test_an_indenter_that_is_not_as_stated_is_named(world):
    """Forces of one of four indenters 15 % low; the control has them as they are."""
    names = np.array([f"solid {k % 4}" for k in range(world.count)])
    factor = np.repeat(np.where(names == "solid 2", 0.85, 1.0), FRAMES)[:, None]

    def codes(measured):
        experiment = world.experiment(measured, "wide")
        touches = tuple(
            replace(touch, indenter=str(name)) for touch, name in zip(experiment.touches, names, strict=True)
        )
        found = fit(replace(experiment, touches=touches), NOISE, WIDE, CalibrationOptions(bounds="wide"))
        return by_code(remarks(found, WIDE, 4e-5, {}, True, 0.03)), found.shape_factors

    clean = world.measured()
    said_of, factors = codes(clean * factor)
    assert "solid 2 -" in said_of["calibration-shape"]
    assert "solid 1" not in said_of["calibration-shape"]
    assert factors["solid 2"] + 0.1 < min(factors[name] for name in ("solid 0", "solid 1", "solid 3"))
    assert "calibration-shape" not in codes(clean)[0]


def test_forces_of_all_indenters_off_alike_do_not_blame_their_sizes(world):
    """All off in one direction: a bound or missing physics; some off, or in both directions: sizes."""
    found = fit(world.experiment(world.measured(), "wide"), NOISE, WIDE, CalibrationOptions(bounds="wide"))

    def shape(**factors):
        return by_code(remarks(replace(found, shape_factors=factors), WIDE, 4e-5, {}, True, 0.03))["calibration-shape"]

    assert shape(ball=1.12, dome=1.15).rstrip().endswith("or physics is missing")
    assert shape(ball=0.88, dome=0.85).rstrip().endswith("or physics is missing")
    for other in ({"ball": 1.12, "dome": 0.85}, {"ball": 1.12, "dome": 1.01}, {"ball": 1.12}):
        assert "may not be as stated" in shape(**other)
        assert "bound" not in shape(**other)
