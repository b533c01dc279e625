"""Effects of time, against exact integrals."""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import quad

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.effects.touch.relaxing_shear import relaxing_shear
from tactiledata.effects.touch.time_operators import delayed, fading_memory


def convolution(seconds, force, at, time):
    """The exact integral of exp(-(t - s) / time) dF(s) up to t = at, F straight between frames."""
    slopes = np.diff(force) / np.diff(seconds)

    def slope(s):
        return slopes[min(np.searchsorted(seconds, s, side="right") - 1, len(slopes) - 1)]

    return quad(lambda s: np.exp(-(at - s) / time) * slope(s), seconds[0], at, points=seconds[1:-1], limit=500)[0]


@pytest.mark.parametrize("time", [0.05, 1.0, 40.0])
def test_memory_is_the_convolution_integral(time):
    """The memory on frames of uneven spacing is the convolution integral, found by quadrature."""
    rng = np.random.default_rng(0)
    seconds = np.cumsum(rng.uniform(0.02, 0.5, 20))
    wrench = np.cumsum(rng.normal(size=(20, 6)), axis=0)
    memory = fading_memory(seconds, wrench, time)
    for frame in (1, 7, 19):
        assert memory[frame, 2] == pytest.approx(convolution(seconds, wrench[:, 2], seconds[frame], time), rel=1e-7)


def test_memory_does_not_depend_on_the_frame_interval():
    """Frames between frames change nothing: the recursion is exact on straight pieces."""
    coarse = np.array([0.0, 1.0, 4.0, 10.0])
    wrench = np.outer([0.0, 5.0, 5.0, 1.0], np.ones(6))
    fine = np.linspace(0.0, 10.0, 101)
    between = np.stack([np.interp(fine, coarse, column) for column in wrench.T], axis=1)
    there = fading_memory(fine, between, 2.0)[np.isin(np.round(fine, 9), coarse)]
    np.testing.assert_allclose(there, fading_memory(coarse, wrench, 2.0), rtol=1e-12)


def test_relaxation_after_a_ramp_is_a_prony_term(touch, play, moved):
    """Ramp in T, then hold: F(t) = F_e + g F_e (tau / T) (1 - exp(-T / tau)) exp(-(t - T) / tau), also in shear."""
    seconds = np.concatenate([np.linspace(0.0, 0.01, 2), 0.01 + np.geomspace(0.01, 30.0, 20)])
    path = moved(touch, seconds, np.concatenate([[0.0], np.full(21, 8e-4)]))
    plain = play(on=path).wrench[:, 2]
    found = play("relaxation", on=path, share=0.1, time=3.0).wrench[:, 2]
    rise = 3.0 / 0.01 * -np.expm1(-0.01 / 3.0)
    wanted = plain[1:] * (1 + 0.1 * rise * np.exp(-(seconds[1:] - 0.01) / 3.0))
    np.testing.assert_allclose(found[1:], wanted, rtol=1e-12)


def test_a_slow_loop_closes(touch, play, moved):
    """Loading and unloading part ways at a usual rate, and meet again when it is ten thousand times slower."""
    depth = 8e-4 * np.concatenate([np.linspace(0, 1, 21), np.linspace(0.95, 0, 20)])
    loops = []
    for pace in (1.0, 1e4):
        path = moved(touch, pace * np.arange(41.0) / 10, depth)
        force = play("relaxation", on=path, share=0.1, time=3.0).wrench[:, 2]
        loops.append(np.abs(force[:21] - force[20:][::-1])[5:16].max())
    assert loops[0] > 0.1
    assert loops[1] < 0.005 * loops[0]


def test_a_gel_that_relaxed_parts_without_pulling(touch, play, moved):
    """Left fast after a long dwell, the contact ends early: never tension, and free air is exactly free."""
    seconds = np.concatenate([[0.0, 0.1, 60.0], 60.0 + np.linspace(0.01, 0.1, 10)])
    depth = 8e-4 * np.concatenate([[0.0, 1.0, 1.0], np.linspace(0.9, -0.2, 10)])
    path = moved(touch, seconds, depth)
    plain, state = play(on=path), play("relaxation", on=path, share=0.3, time=3.0)
    assert (state.wrench[:, 2] >= 0).all()
    assert (state.wrench[~plain.contact.touching] == 0).all()
    early = (plain.wrench[:, 2] > 0) & (state.wrench[:, 2] == 0)
    assert early.any()


def test_friction_holds_while_it_relaxes(touch, play):
    """Sliding shear is mu N of the relaxing normal force; sticking shear never exceeds it."""
    state = play("relaxation", share=0.3, time=1.0)
    shear, normal = np.hypot(*state.wrench[:, :2].T), state.wrench[:, 2]
    sliding, mu = state.contact.sliding, touch.material.friction
    assert np.abs(normal - play().wrench[:, 2])[sliding].max() > 0.01
    np.testing.assert_allclose(shear[sliding], mu * normal[sliding], rtol=1e-9)
    assert (shear <= mu * normal + 1e-9)[normal > 0.01].all()


def test_a_spectrum_is_the_same_effect_several_times(touch, play):
    """Two weak terms add, up to their product."""
    settings = [EffectSetting("relaxation", {"share": 0.02, "time": time}) for time in (0.3, 10.0)]
    both = with_effects(BallOnLayer, settings).play(touch).wrench
    plain = play().wrench
    added = sum(play("relaxation", share=0.02, time=time).wrench - plain for time in (0.3, 10.0))
    pressed = play().contact.depth > 1e-4
    np.testing.assert_allclose((both - plain)[pressed], added[pressed], atol=2 * 0.02**2 * np.abs(plain).max())


def test_a_lag_shifts_ramps_and_is_over_in_a_dwell(touch, play, moved):
    """A delay moves a ramp by delay times slope; a filter ends there too; a second later all is as simulated."""
    seconds = np.arange(0.0, 6.0, 0.05)
    # a force that is a straight ramp: depths that the base turns into one
    depth = np.interp(seconds, [0.0, 3.0], [0.0, 8e-4])
    path = moved(touch, seconds, depth)
    plain = play(on=path).wrench[:, 2]
    for values in ({"delay": 0.05}, {"filter": 0.05}):
        found = play("lag", on=path, **values).wrench[:, 2]
        slope = np.gradient(plain, seconds)
        np.testing.assert_allclose(found[40:55], (plain - 0.05 * slope)[40:55], atol=0.006)
        np.testing.assert_allclose(found[-20:], plain[-20:], rtol=1e-6)
    early = play("lag", on=path, delay=-0.05).wrench[:, 2]
    np.testing.assert_allclose(early[:-1], plain[1:], rtol=1e-9, atol=1e-12)


def test_a_delay_interpolates_between_frames():
    """Half a frame late is the mean of two; before the first frame its value is held."""
    wrench = np.outer([0.0, 1.0, 4.0], np.ones(6))
    late = delayed(np.array([0.0, 1.0, 2.0]), wrench, 0.5)
    np.testing.assert_allclose(late[:, 0], [0.0, 0.5, 2.5])


def test_skew_grows_with_the_recording_and_a_jump_stays(touch, play):
    """A rate delays by rate times the time since the recording began; a jump only what comes after it."""
    early = dataclasses.replace(touch, seconds=touch.seconds - 300.0)
    late = dataclasses.replace(touch, seconds=touch.seconds + 300.0)
    changes = [np.abs(play("clock_skew", on=on, rate=1e-4).wrench - play().wrench).max() for on in (early, touch, late)]
    assert changes[0] < 0.05 * changes[1]
    assert changes[2] / changes[1] == pytest.approx(2.0, rel=0.15)
    middle = float(touch.seconds[130])
    state = play("clock_skew", jump=0.05, jump_at=middle)
    np.testing.assert_array_equal(state.wrench[:130], play().wrench[:130])
    np.testing.assert_allclose(state.wrench[130:], play().wrench[129:-1], atol=1e-9)


def test_shear_that_sticks_is_linear_and_a_null_share_changes_no_bit():
    """Shear that sticks relaxes as linear viscoelasticity does, and a share of 0 changes no bit."""
    rng = np.random.default_rng(3)
    seconds, elastic = np.cumsum(rng.uniform(0.05, 2.0, 30)), np.cumsum(rng.normal(size=(30, 2)), axis=0)
    sticks, far = np.zeros(30, dtype=bool), np.full(30, 1e3)
    found = relaxing_shear(seconds, elastic, sticks, elastic, far, 0.2, 3.0)
    wanted = elastic + 0.2 * fading_memory(seconds, np.pad(elastic, ((0, 0), (0, 4))), 3.0)[:, :2]
    np.testing.assert_allclose(found, wanted, rtol=1e-10)
    slides, limit = rng.random(30) < 0.3, np.hypot(*elastic.T)
    assert (relaxing_shear(seconds, elastic, slides, elastic, limit, 0.0, 3.0) == elastic).all()


@pytest.mark.parametrize("told_by", ["the simulation", "the limit"])
def test_what_comes_to_rest_after_a_slide_relaxes_from_there(told_by):
    """Pulled at once to the limit C, slid for T: memory C / (1 + g) exp(-T / (tau (1 + g))) is left, and decays."""
    share, time, limit, slide = 0.2, 3.0, 2.0, 4.0
    seconds = np.concatenate([[0.0], np.linspace(1e-6, slide, 801), slide + np.linspace(0.01, 9.0, 300)])
    moves = (seconds > 0) & (seconds <= slide)
    # an elastic answer that slides, or one that would pull far beyond the limit
    far = 0.0 if told_by == "the simulation" else 3.0
    way = np.where(seconds > 0, limit, 0.0) + far * np.minimum(seconds, slide)
    elastic = np.outer(way, [0.6, 0.8])
    sliding = limit * elastic / np.maximum(way, 1e-9)[:, None]
    slides = moves if told_by == "the simulation" else np.zeros_like(moves)
    found = relaxing_shear(seconds, elastic, slides, sliding, np.full(len(seconds), limit), share, time)
    np.testing.assert_allclose(found, np.outer(found @ [0.6, 0.8], [0.6, 0.8]), atol=1e-12)
    np.testing.assert_allclose((found @ [0.6, 0.8])[moves], limit, rtol=1e-9)
    left = limit / (1 + share) * np.exp(-slide / (time * (1 + share)))
    rest = seconds > slide
    wanted = limit - share * left * -np.expm1(-(seconds[rest] - slide) / time)
    np.testing.assert_allclose((found @ [0.6, 0.8])[rest], wanted, rtol=1e-3)


@pytest.mark.parametrize("lifted", [0.0, -1.0])
def test_free_air_ends_a_shear_and_its_memory(lifted):
    """Lifted for one frame, the contact starts anew: what follows is as if nothing had been before."""
    seconds = np.arange(8.0)
    elastic = np.outer([0.0, 1.0, 2.0, 0.0, 0.5, 1.0, 1.5, 1.5], [0.6, 0.8])
    limit = np.array([9.0, 9.0, 9.0, lifted, 9.0, 9.0, 9.0, 9.0])
    sticks = np.zeros(8, dtype=bool)
    found = relaxing_shear(seconds, elastic, sticks, elastic, limit, 0.2, 3.0)
    fresh = relaxing_shear(seconds[3:], elastic[3:], sticks[3:], elastic[3:], limit[3:], 0.2, 3.0)
    np.testing.assert_allclose(found[3:], fresh, atol=1e-12)
    np.testing.assert_allclose(found[3], 0.0, atol=1e-12)


def test_a_slide_that_takes_long_leaves_the_strain_that_has_its_shear():
    """After three time constants at the limit C, S = C / (1 + g k) with k = (1 - e^-3) / 3; it decays at rest."""
    share, time, limit = 0.5, 2.0, 3.0
    seconds = np.array([0.0, 6.0, 7.0, 9.0])
    elastic = np.outer([0.0, 4.0, 4.0, 4.0], [0.6, 0.8])
    slides = np.array([False, True, False, False])
    sliding = np.outer([0.0, limit, 0.0, 0.0], [0.6, 0.8])
    found = relaxing_shear(seconds, elastic, slides, sliding, np.full(4, limit), share, time)
    mean = (1 - np.exp(-3.0)) / 3.0
    strain = limit / (1 + share * mean)
    wanted = [0.0, limit, *(strain * (1 + share * mean * np.exp(-np.array([0.5, 1.5]))))]
    np.testing.assert_allclose(found @ [0.6, 0.8], wanted, rtol=1e-12)


def test_a_shear_that_begins_loaded_remembers_nothing_of_before():
    """The first frame is as the relaxed gel has it, and so is all that does not move from there; none is none."""
    held = np.tile([[0.6, 0.8]], (4, 1))
    sticks = np.zeros(4, dtype=bool)
    np.testing.assert_allclose(relaxing_shear(np.arange(4.0), held, sticks, held, np.full(4, 9.0), 0.4, 2.0), held)
    none = np.zeros((0, 2))
    assert relaxing_shear(np.zeros(0), none, sticks[:0], none, np.zeros(0), 0.4, 2.0).shape == (0, 2)
