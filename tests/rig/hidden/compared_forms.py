"""How near the catalogue's formula of an effect comes to the rig's, on the rig's own contact: no solver is between.

E and mu are free, as in a diagnosis: formulas that differ by what a gel of another E or mu does are alike.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from hidden_worlds import PRESS, SLIDE, played, touch
from scipy.optimize import least_squares

from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import Simulator
from tactiledata.effects.touch.response import ContactResponse
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.prove.worlds.generators import closed_form
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.rig.contact.closed_form import ContactLaw, contact_law, press_along, stick_slip
from tactiledata.rig.contact.contact import contact_times
from tactiledata.sensors.base import GelGeometry

BACK = {"shear": {"by": [-0.0012, 0.0006], "step": 0.0012, "speed": 0.004, "settle": 0.1}}
WAYS = [PRESS, {"dwell": {"time": 1.0}}, SLIDE, BACK]
PLACES = {
    "ball": (0.001, -0.002),
    "small": (-0.004, 0.005),
    "punch": (0.0055, 0.007),
}
"""Place on the gel, x and y in metres, at which each indenter touches: near the middle, aside, near the border."""
POWERED = (60.0, 300.0, 900.0, 2400.0)
"""Time, s, since power-on at the start of the log of each touch."""
STARTS = 2
"""Starts from which a fit is made: the best ones."""
MOST = 40
"""Largest number of evaluations of a fit, without those for its derivatives."""
OF_VARIANTS = ("radius_error",)
"""Parameters that another gel or indenter is played for: no formula of the catalogue has them."""


def sample_touches():
    """Touches of the three indenters, leaning over a wedge, and one of a ball that is only pressed."""
    placed = {"tilt": [0.05, -0.05], "force_limit": 60.0}
    slides = [touch(name, name, place, WAYS, yaw=0.4 * k, **placed) for k, (name, place) in enumerate(PLACES.items())]
    return [*slides, touch("only", "ball", (-0.002, 0.001), [PRESS, {"dwell": {"time": 2.0}}], **placed)]


@dataclass(frozen=True)
class RigResponse:
    """`BaseResponse` by the rig's closed forms along a path.

    Parameters
    ----------
    law : ContactLaw
        The contact of the indenter.
    positions : (n, 3) m
        x, y and depth of the tip.
    """

    law: ContactLaw
    positions: np.ndarray

    def of_gel(self, stiffer, rougher):
        """Return the response along the same path of a gel whose E and mu are larger by these shares, 0 for none."""
        law, by = self.law, 1.0 + stiffer
        other = replace(
            law, force=by * law.force, stiffness=by * law.stiffness, friction=law.friction * (1.0 + rougher)
        )
        return RigResponse(other, self.positions)

    def respond(self, offset, shift, friction):
        """The contact with an indenter that is elsewhere, and with another friction in each frame."""
        at = self.positions + np.column_stack([shift, offset])
        wrench = press_along(self.law, at).wrench
        normal, stiffness, _ = self.law.columns_at(at[:, 2])
        pull, sliding = stick_slip(at[:, :2], normal, stiffness, self.law.friction * friction)
        wrench[:, :2] = -pull
        touches = normal > 0
        area = np.where(touches, np.pi * np.interp(at[:, 2], self.law.depth, self.law.radius) ** 2, 0.0)
        return ContactResponse(wrench, area, at[:, :2], at[:, 2], sliding, np.where(touches, stiffness, 0.0))

    def difference(self, variant):
        """No other gel is known."""
        raise UsageError("a variant of the gel", "the gel of the rig", "Compare effects that have a formula.")


@dataclass(frozen=True)
class KnownResponse:
    """`BaseResponse` that answers with one wrench, whatever is asked: for effects of what the sensor reads."""

    wrench: np.ndarray

    def of_gel(self, stiffer, rougher):
        """Return the response itself: what a sensor changes does not depend on the gel."""
        return self

    def respond(self, offset, shift, friction):
        """The wrench (n, 6)."""
        count = len(self.wrench)
        touches = self.wrench[:, 2] > 0
        area = np.where(touches, 1e-6, 0.0)
        zeros = np.zeros(count)
        return ContactResponse(self.wrench, area, np.zeros((count, 2)), zeros, touches & False, zeros)

    difference = RigResponse.difference


@dataclass(frozen=True)
class Compared:
    """Touches with what the rig's effect changes in them, and a base on which the catalogue's formula acts.

    Parameters
    ----------
    touches : list of Touch
        With all that effects may depend on.
    bases : list of BaseResponse
        One for each.
    change : (N, c)
        What the rig's effect changes in the first c columns of the wrench, all touches one after the other.
    """

    touches: list
    bases: list
    change: np.ndarray

    def of_catalogue(self, setting, stiffer=0.0, rougher=0.0):
        """What a setting of the catalogue changes (N, c), on a gel with another E and mu."""
        parts = []
        for one, base in zip(self.touches, self.bases, strict=True):
            gel, none = base.of_gel(stiffer, rougher), np.zeros(len(one))
            changed = Simulator(lambda _, gel=gel: gel, (setting,)).play(one).wrench
            parts.append(changed - base.respond(none, np.zeros((len(one), 2)), none + 1.0).wrench)
        return np.concatenate(parts)[:, : self.change.shape[1]]

    def left(self, name):
        """Root mean square that the nearest setting of an effect leaves, as a share of the change."""
        parameters = [one for one in EFFECTS[name]().parameters if one.name not in OF_VARIANTS]
        free = [one for one in parameters if one.null is not None or len(one.grid) > 1]
        scales = np.array([*map(_scale, free), 0.1, 0.1])
        low, high = (
            np.array([*(one.bounds[end] for one in free), (-0.5, 0.5)[end], (-0.5, 0.5)[end]]) for end in (0, 1)
        )
        size = np.sqrt(np.sum(self.change**2))

        def missing(x):
            *values, stiffer, rougher = np.clip(x * scales, low, high)
            told = dict(zip((one.name for one in free), map(float, values), strict=True))
            try:
                return ((self.of_catalogue(EffectSetting(name, told), stiffer, rougher) - self.change) / size).ravel()
            except UsageError as error:
                if "no balance" not in str(error):
                    raise
                return np.ones(self.change.size)

        starts = [
            np.clip([*start, 0.0, 0.0], low + 1e-6 * (high - low), high - 1e-6 * (high - low)) / scales
            for start in product(*_starts(free))
        ]
        best = sorted(starts, key=lambda start: float(np.sum(missing(start) ** 2)))[:STARTS]
        ends = low / scales, high / scales
        found = [
            least_squares(missing, start, bounds=ends, diff_step=1e-3, max_nfev=MOST, x_scale="jac") for start in best
        ]
        return float(np.sqrt(min(2 * one.cost for one in found)))


def _scale(one):
    """Unit, in that of the parameter, in which a fit counts it: its prior's deviation, or a twentieth of its bounds."""
    return one.deviation or (one.bounds[1] - one.bounds[0]) / 20


def _starts(free):
    """Values of each free parameter from which fits may start: shapes over their grids, strengths on both sides."""
    few = sum(one.null is not None for one in free) <= 3
    for one in free:
        if one.null is None:
            yield one.grid[:: max(1, len(one.grid) // 4)]
        else:
            step = 0.5 * _scale(one)
            yield [-step, step] if few and one.bounds[0] < 0 else [step if few else 0.1 * step]


def in_contact(entry, indenter=None):
    """What an effect on a contact changes in the forces of single touches, of one indenter or all, on a fresh gel."""
    touches, bases, changes = [], [], []
    for told, since in zip(sample_touches(), POWERED, strict=True):
        if indenter not in (None, told["indenter"]):
            continue
        quiet = {"tare": "none", "powered": since}
        plain, changed = (played(hidden, [told], recordings=quiet).performance for hidden in ([], [entry]))
        play = plain.plays[0]
        setup = play.contact.setup
        seconds = contact_times(play.path)
        positions = play.path.at(seconds) + setup.offset
        poses = np.tile(np.eye(4), (len(seconds), 1, 1))
        poses[:, :3, :3] = setup.rotation
        poses[:, :3, 3] = positions * [1.0, 1.0, -1.0]
        gel = GelMaterial(setup.material.youngs_modulus, setup.material.poisson_ratio, setup.material.friction)
        height, none = setup.thickness, np.zeros(len(seconds))
        outline = tuple(setup.footprint.grid.outline)
        touches.append(Touch(
            seconds=seconds, poses=poses, indenter=setup.indenter, material=gel,
            geometry=GelGeometry(outline=outline, thickness=height, edge_thickness=height),
            indenter_name=told["indenter"], earlier_depth=none, earlier_contacts=none,
            powered=seconds + (play.start_ns - plain.start_ns) * 1e-9 + since,
        ))  # fmt: skip
        bases.append(RigResponse(contact_law(setup.indenter, setup.footprint, height, setup.material), positions))
        changes.append((changed.plays[0].contact.wrench - play.contact.wrench)[:, :3])
    return Compared(touches, bases, np.concatenate(changes))


def in_readings(entry, folder, plan="wedge-1x9"):
    """What an effect changes in the wrenches that a diagnosis reads, without noise."""
    maker = WorldMaker.of(named_plan(plan), folder)
    maker = replace(maker, solve=closed_form)
    plain, changed = (maker.recorded(3, maker.plan.truth, hidden, is_exact=True) for hidden in ([], [entry]))
    cases = maker.cases(plain, None).touches
    change = np.concatenate(changed.wrenches) - np.concatenate(plain.wrenches)
    return Compared([case.touch for case in cases], [KnownResponse(case.measured) for case in cases], change)
