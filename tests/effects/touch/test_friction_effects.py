"""Effects of the interface while it sticks and slides."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.interface.partial_slip import slip_levels
from tactiledata.effects.touch.last_move import SLOWEST as STANDING
from tactiledata.effects.touch.last_move import WAYS

FRICTION_EFFECTS = ("area_friction", "rate_friction", "static_friction", "partial_slip")
DEPTH = 8e-4


def slide(touch, moved, x, speed=1e-3, hold=0.0):
    """Press to 0.8 mm, hold, then move along x (m,) at a speed; frames of the slide are the last m."""
    steps = np.abs(np.diff(x)) / speed
    seconds = np.concatenate([[0.0, 1.0], 1.0 + hold + np.cumsum([1.0, *steps])])
    depth = np.concatenate([[0.0, DEPTH], np.full(len(x), DEPTH)])
    return moved(touch, seconds, depth, x=np.concatenate([[x[0], x[0]], x]))


@pytest.mark.parametrize("name", FRICTION_EFFECTS)
def test_friction_leaves_the_normal_force_alone(name, play, medium):
    """Only shear, and the torques of shear, change."""
    change = play(name, **medium(name)).wrench - play().wrench
    assert np.abs(change[:, :2]).max() > 0.05
    np.testing.assert_allclose(change[:, 2], 0.0, atol=1e-12)


def test_area_friction_is_a_sum_of_area_and_load(touch, play, moved):
    """The plateau is F_t = tau A + alpha N with alpha = mu - tau / p0, at any depth."""
    tau, p0, mu = 1e5, 3e5, touch.material.friction
    for depth in (2e-4, 5e-4, 1e-3):
        path = slide(touch, moved, np.linspace(0.0, 4e-3, 41))
        path.poses[1:, 2, 3] = -depth
        state = play("area_friction", on=path, shear_strength=tau, pressure=p0)
        assert state.contact.sliding[-1]
        wanted = tau * state.contact.area[-1] + (mu - tau / p0) * state.wrench[-1, 2]
        assert np.hypot(*state.wrench[-1, :2]) == pytest.approx(wanted)


@pytest.mark.parametrize("saturation", [1e-6, 4e-6, 2e-5])
def test_a_limited_shear_stress_is_summed_over_hertzs_pressure(touch, play, moved, saturation):
    """The plateau is the sum of min(mu p(r), tau) over rings of a Hertzian contact, over that of the usual pressure."""
    p0, mu = 2e5, touch.material.friction
    radii = (np.arange(20_000) + 0.5) / 20_000

    def of_coulomb(mean):
        pressure = 1.5 * mean * np.sqrt(1.0 - radii**2)
        return float(np.sum(np.minimum(mu * pressure, 1.0 / saturation) * radii) / np.sum(mu * pressure * radii))

    for depth in (2e-4, 5e-4, 1e-3):
        path = slide(touch, moved, np.linspace(0.0, 4e-3, 41))
        path.poses[1:, 2, 3] = -depth
        state = play("area_friction", on=path, saturation=saturation, pressure=p0)
        mean = state.wrench[-1, 2] / state.contact.area[-1]
        assert state.friction[-1] == pytest.approx(of_coulomb(mean) / of_coulomb(p0), rel=1e-6)
        if saturation == 2e-5:
            # a shear strength alone: in proportion to the area
            share = p0 * state.contact.area[-1] / state.wrench[-1, 2]
            assert state.friction[-1] == pytest.approx(share, rel=0.12)


def test_rate_friction_is_a_line_over_the_logarithm_of_speed(touch, play, moved):
    """Plateaus at four speeds lie on mu (1 + beta log10(v / v0)); a rest keeps what the last move had."""
    for speed in (1e-4, 3e-4, 1e-3, 1e-2):
        path = slide(touch, moved, np.linspace(0.0, 4e-3, 41), speed=speed)
        wrench = play("rate_friction", on=path, beta=0.15).wrench[-1]
        wanted = touch.material.friction * (1 + 0.15 * np.log10(speed / 1e-3))
        assert np.hypot(*wrench[:2]) / wrench[2] == pytest.approx(wanted)
    resting = np.concatenate([np.linspace(0.0, 4e-3, 41), [4e-3]])
    seconds = np.arange(len(resting) + 2.0)
    rest = moved(touch, seconds, np.full(len(seconds), DEPTH), x=np.concatenate([[0.0, 0.0], resting]))
    factor = play("rate_friction", on=rest, beta=0.15).friction
    assert factor[-1] == factor[-2]
    assert factor[0] == 1.0


def test_a_contact_at_rest_creeps_down_the_law_of_speed(touch, play, moved):
    """From where it stands F falls by A ln(1 + k u t / A), A = beta mu N / ln 10: dF = -k v dt on the law."""
    there = np.concatenate([np.zeros(2), np.linspace(0.0, 4e-3, 41), np.full(4, 4e-3)])
    depth = np.concatenate([[0.0], np.full(46, DEPTH)])
    path = moved(touch, np.arange(47.0), depth, x=there)
    pace, rest = np.full(len(path), 1e-3), np.zeros(len(path))
    rest[-4:] = [0.01, 0.1, 1.0, 10.0]
    path = dataclasses.replace(path, pace=pace, rest=rest)
    state, gel = play("rate_friction", on=path, beta=0.12), touch.material
    normal = state.wrench[-1, 2]
    scale = 0.12 * gel.friction * normal / np.log(10.0)
    spring = 8 * gel.shear_modulus * state.contact.radius[-1] / (2 - gel.poisson_ratio)  # of the ball on a layer
    stands = gel.friction * normal * (1 + 0.12 * np.log10(STANDING / 1e-3))
    wanted = stands - scale * np.log1p(spring * STANDING * rest[-4:] / scale)
    np.testing.assert_allclose(np.hypot(*state.wrench[-4:, :2].T), wanted, rtol=1e-9)
    assert np.hypot(*state.wrench[-5, :2]) == pytest.approx(gel.friction * normal)
    # what slides the easier the faster does not creep
    np.testing.assert_allclose(
        play("rate_friction", on=path, beta=-0.12).friction[-4:], 1 - 0.12 * np.log10(STANDING / 1e-3)
    )


def test_static_friction_peaks_once_and_dies_out(touch, play, moved):
    """The peak is mu N (1 + excess); it decays over the memory length; sliding on has no second one, a rest has."""
    limit = play(on=slide(touch, moved, np.linspace(0.0, 4e-3, 401))).wrench[-1]
    limit = touch.material.friction * limit[2]
    there = np.linspace(0.0, 4e-3, 401)
    shear = -play("static_friction", on=slide(touch, moved, there), excess=0.3, length=2e-4).wrench[:, 0] / limit
    onset = int(np.argmax(shear))
    assert shear[onset] == pytest.approx(1.3, rel=0.01)
    slipped = there[onset + 21 - 2] - there[onset - 2]
    assert shear[onset + 21] == pytest.approx(1 + 0.3 * np.exp(-slipped / 2e-4), rel=0.01)
    assert shear[-1] == pytest.approx(1.0, abs=1e-3)
    assert (np.diff(shear[onset:]) <= 1e-12).all()
    back = np.concatenate([there, there[-2::-1]])
    returning = play("static_friction", on=slide(touch, moved, back), excess=0.3, length=2e-4).wrench[:, 0] / limit
    assert returning.max() == pytest.approx(1.3, rel=0.01)


def test_static_friction_ages_with_the_logarithm_of_rest(touch, play, moved):
    """A hundred seconds of rest add about two decades."""
    there = np.linspace(0.0, 4e-3, 401)
    peaks = []
    for hold in (0.0, 100.0, 10000.0):
        path = slide(touch, moved, there, hold=hold)
        wrench = play("static_friction", on=path, excess=0.2, ageing=0.04).wrench  # mu is that of 1 mm/s and 0.2 mm
        peaks.append(-wrench[:, 0].min() / wrench[-1, 2] / touch.material.friction)
    rests = np.array([0.0, 100.0, 10000.0]) + 2.4  # from the first contact until it slips
    np.testing.assert_allclose(peaks, 1.2 + 0.04 * np.log10((1 + rests) / 1.2), atol=0.01)


def test_a_long_slide_is_as_old_as_it_takes_to_forget(touch, play, moved):
    """At steady speed the age is length / v, so that a fast slide is easier: Dieterich's law."""
    for speed in (1e-4, 1e-3, 1e-2):
        path = slide(touch, moved, np.linspace(0.0, 4e-3, 41), speed=speed)
        wrench = play("static_friction", on=path, ageing=0.1, length=1e-4, time=0.05).wrench[-1]
        wanted = touch.material.friction * (1 + 0.1 * np.log10((0.05 + 1e-4 / speed) / (0.05 + 0.1)))
        assert np.hypot(*wrench[:2]) / wrench[2] == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("values", [{"beta": 0.2}, {"excess": 0.3, "ageing": 0.1, "length": 1e-4}])
def test_mu_is_that_of_the_speed_that_is_told(touch, play, moved, values):
    """A long slide at v0 rubs as simulated, one at another speed does not, and v0 is what the answer says."""
    name = "rate_friction" if "beta" in values else "static_friction"
    effect = EFFECTS[name]()
    for speed in (1e-3, 1e-4):
        path = slide(touch, moved, np.linspace(0.0, 4e-3, 41), speed=speed)
        factor = play(name, on=path, **values, speed=1e-3).friction[-1]
        assert (factor == pytest.approx(1.0, abs=1e-9)) == (speed == 1e-3)
    assert effect.material_of(effect.complete({"speed": 2e-3}))["mu"].endswith("slide at 2 mm/s")


def test_mu_is_that_of_the_pressure_that_is_told(play):
    """Where the mean pressure is p0 friction is as simulated, and p0 is what the answer says."""
    plain = play()
    deepest = int(np.argmax(plain.contact.wrench[:, 2]))
    pressure = float(plain.contact.wrench[deepest, 2] / plain.contact.area[deepest])
    for p0, is_simulated in ((pressure, True), (2 * pressure, False)):
        rubbed = play("area_friction", shear_strength=5e4, pressure=p0)
        assert (rubbed.friction[deepest] == pytest.approx(1.0)) == is_simulated
    effect = EFFECTS["area_friction"]()
    assert "0.25 MPa" in effect.material_of(effect.complete({"pressure": 2.5e5}))["mu"]


def test_a_slide_that_ends_slowly_is_older_than_its_pace_says(touch, play, moved):
    """A slide is as old as its last ``length`` took; what comes after its end as rest is not in its pull."""
    path = slide(touch, moved, np.linspace(0.0, 4e-3, 41), speed=1e-2)
    took = np.outer(np.ones(len(path)), np.sqrt(np.array(WAYS) / 1e-3))  # a brake of 2 mm/s^2
    rest = np.zeros(len(path))
    path = dataclasses.replace(path, pace=np.full(len(path), 1e-2), rest=rest, last_ways=took)
    values = {"ageing": 0.1, "length": WAYS[3], "time": 0.05}
    wrench = play("static_friction", on=path, **values).wrench[-1]
    older = (0.05 + np.sqrt(WAYS[3] / 1e-3)) / (0.05 + WAYS[3] / 1e-3)
    wanted = touch.material.friction * (1 + 0.1 * np.log10(older))
    assert np.hypot(*wrench[:2]) / wrench[2] == pytest.approx(wanted, rel=1e-6)


def test_partial_slip_is_mindlins_curve(touch, play, moved):
    """F_t = mu N [1 - (1 - u / u*)^(3/2)], within 1 % of mu N; loops after a reversal follow Masing's rule."""
    limit = touch.material.friction * play(on=slide(touch, moved, np.array([0.0, 1e-6]))).wrench[-1, 2]
    spring = 8 * touch.material.shear_modulus * play(on=slide(touch, moved, np.array([0.0, 1e-6]))).contact.radius[-1]
    spring /= 2 - touch.material.poisson_ratio
    full = 1.5 * limit / spring

    def mindlin(u):
        return limit * (1 - (1 - np.minimum(u / full, 1)) ** 1.5)

    turn = 0.7 * full
    there = np.linspace(0.0, turn, 101)
    path = slide(touch, moved, np.concatenate([there, there[-2::-1]]))
    shear = -play("partial_slip", on=path, share=1.0).wrench[2:, 0]
    np.testing.assert_allclose(shear[:101], mindlin(there), atol=0.01 * limit)
    returned = mindlin(turn) - 2 * mindlin((turn - there[-2::-1]) / 2)
    np.testing.assert_allclose(shear[101:], returned, atol=0.02 * limit)


def test_slip_levels_are_equal_parts_of_mindlins_distribution():
    """Their mean is 1, and the mean of what they can hold is the curve."""
    levels = slip_levels(400)
    assert levels.mean() == pytest.approx(1.0)
    for stretch in (0.1, 0.5, 1.0, 1.4):
        wanted = 1 - (1 - 2 * stretch / 3) ** 1.5
        assert np.minimum(levels, stretch).mean() == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize(
    ("length", "took"),
    [
        (WAYS[0] / 2, 1.0),
        (np.sqrt(WAYS[2] * WAYS[3]), 3.5),
        (WAYS[2] ** 0.25 * WAYS[3] ** 0.75, 3.75),
        (WAYS[5], 6.0),
        (2 * WAYS[5], 6.0),
    ],
)
def test_ages_lie_between_those_of_the_ways_next_to_the_length(touch, moved, play, length, took):
    """Ages between two ways follow the logarithm; below the first way and beyond the last they are those of these."""
    path = slide(touch, moved, np.linspace(0.0, 40e-3, 41), speed=1e-2)
    ways = np.tile(np.arange(1.0, 7.0), (len(path), 1))
    rest = np.full(len(path), 0.05)
    path = dataclasses.replace(path, pace=np.full(len(path), 1e-2), rest=rest, last_ways=ways)
    factor = play("static_friction", on=path, ageing=0.1, length=length, time=0.05).friction[-1]
    assert factor == pytest.approx(1 + 0.1 * np.log10((0.05 + took - 0.05 + _kept(length)) / (0.05 + length / 1e-3)))


def _kept(length):
    """What is left of the rest after each of many moves of a millimetre, which adds to the age."""
    return 0.05 / (np.exp(1e-3 / length) - 1.0)


def test_below_a_thousandth_of_its_speed_friction_stays_as_it_is_there(touch, moved, play):
    """Four decades below v0 it is 1 - 3 beta; a little above three decades, in frames alone, it is on the law."""
    stated = slide(touch, moved, np.linspace(0.0, 4e-3, 41), speed=1e-3)
    stated = dataclasses.replace(stated, pace=np.full(len(stated), 1e-7), rest=np.zeros(len(stated)))
    assert play("rate_friction", on=stated, beta=0.1, speed=1e-3).friction[-1] == pytest.approx(0.7)
    near = slide(touch, moved, np.linspace(0.0, 4e-3, 41), speed=2e-6)
    wanted = 1 + 0.1 * np.log10(2e-3)
    assert play("rate_friction", on=near, beta=0.1, speed=1e-3).friction[-1] == pytest.approx(wanted)


def test_before_any_move_friction_is_as_simulated(touch, moved, play):
    """A press that never slides, and a slide slower than a thousandth of v0, have no speed of their own."""
    still = moved(touch, np.arange(4.0), np.full(4, DEPTH))
    assert play("rate_friction", on=still, beta=0.1).friction.tolist() == [1.0] * 4
    slow = slide(touch, moved, np.linspace(0.0, 4e-6, 41), speed=0.9e-6)
    assert set(play("rate_friction", on=slow, beta=0.1).friction) == {1.0}
    stands = dataclasses.replace(still, pace=np.zeros(4), rest=np.ones(4))
    assert play("rate_friction", on=stands, beta=0.1).friction.tolist() == [1.0] * 4


def test_partial_slip_asks_for_eight_parts(touch, play, moved):
    """Partial slip asks for eight parts beside the answer before it, so that a touch costs nine."""
    asked = []

    class Counted(BallOnLayer):
        def respond(self, offset, shift, friction):
            asked.append(friction[0])
            return super().respond(offset, shift, friction)

    play("partial_slip", on=slide(touch, moved, np.linspace(0.0, 1e-3, 5)), base=Counted, share=0.5)
    assert len(asked) == 9
    np.testing.assert_allclose(sorted(asked), sorted([1.0, *slip_levels(8)]))


def test_without_load_no_friction_is_changed_by_area(touch, moved, play):
    """In free air, and at the surface, the factor is 1; without friction there is nothing to change."""
    path = moved(touch, np.arange(3.0), np.array([-1e-3, 0.0, DEPTH]))
    factor = play("area_friction", on=path, shear_strength=1e5).friction
    assert factor[:2].tolist() == [1.0, 1.0]
    assert factor[2] != 1.0
    smooth = dataclasses.replace(path, material=dataclasses.replace(path.material, friction=0.0))
    assert play("area_friction", on=smooth, shear_strength=1e5).friction.tolist() == [1.0, 1.0, 1.0]


def test_a_contact_that_pulls_has_no_pressure_to_judge_by(touch, moved, play):
    """Touching under a pull, or under nothing, friction is as simulated."""
    path = moved(touch, np.arange(3.0), np.full(3, DEPTH))

    class Pulling(BallOnLayer):
        def respond(self, offset, shift, friction):
            answer = super().respond(offset, shift, friction)
            wrench = answer.wrench.copy()
            wrench[1:, 2] = [-1.0, 0.0]
            return dataclasses.replace(answer, wrench=wrench)

    factor = play("area_friction", on=path, base=Pulling, shear_strength=1e5).friction
    assert factor[0] != 1.0
    assert factor[1:].tolist() == [1.0, 1.0]


def test_an_age_of_nothing_is_that_of_the_pace(touch, moved, play):
    """Where the last way took no time that is known, a slide at v0 is as old as length / v0, and rubs as simulated."""
    path = slide(touch, moved, np.linspace(0.0, 40e-3, 41))
    still = np.zeros(len(path))
    path = dataclasses.replace(path, pace=still + 1e-3, rest=still, last_ways=np.zeros((len(path), len(WAYS))))
    factor = play("static_friction", on=path, ageing=0.1, length=1e-4, time=0.05).friction
    assert factor[-1] == pytest.approx(1.0, abs=1e-9)
