"""Hidden effects that act in a touch, each against a hand computation, and where it must not act."""

import numpy as np
import pytest
from hidden_worlds import PRESS, SLIDE, contact_of, played, stated, touch, world

from tactiledata.rig.contact.closed_form import stick_slip
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.base import Slide
from tactiledata.rig.hidden.friction import HiddenRateFriction
from tactiledata.rig.hidden.pose import HiddenJointCompliance, followed, sensor_poses
from tactiledata.rig.hidden.slider import Loaded, SlidingLaws, slide
from tactiledata.rig.motion import ur5e

PUSHED = [PRESS, SLIDE]
HELD = [PRESS, {"dwell": {"time": 4.0}}]


def last(values, phases, name):
    return values[np.flatnonzero(phases == name)[-1]]


def peaks(log):
    return np.array([play.contact.wrench[:, 2].max() for play in log.performance.plays])


def factor_at_depth(entry, indenter="ball", **changes):
    """Normal force with over without an effect, at full depth."""
    trajectories = [touch(indenter=indenter)]
    _, phases, wrench, _, _ = contact_of([entry], trajectories=trajectories, **changes)
    _, _, plain, _, _ = contact_of(trajectories=trajectories, **changes)
    return last(wrench[:, 2] / np.where(plain[:, 2] > 0, plain[:, 2], 1.0), phases, "press")


def test_thickness_is_a_gel_of_that_thickness():
    """The wrench is that of a world whose gel is said to be so thick."""
    hidden = contact_of([stated("thickness", error=-0.1)])[2]
    stated_so = contact_of(sensors={"D1": {"background": "digit-bg-0", "gel": {"thickness": 0.9 * 0.0041}}})[2]
    np.testing.assert_allclose(hidden, stated_so, rtol=1e-12)
    assert hidden[:, 2].max() > 1.02 * contact_of()[2][:, 2].max()


def test_a_dome_is_lower_and_thinner_away_from_its_middle():
    """A dome of R = 40 mm is lower and thinner by R - sqrt(R² - r²) = 0.202 mm at 4 mm, and as stated in the middle."""
    entry = stated("dome", curvature=25.0)
    aside = played([entry], [touch(position=(0.0, 0.004))]).performance.plays[0]
    assert aside.offset[2] == pytest.approx(-(0.04 - np.sqrt(0.04**2 - 0.004**2)), rel=1e-9)
    assert aside.contact.inner.inner.setup.thickness == pytest.approx(0.0041 + aside.offset[2])
    middle = played([entry], [touch(position=(0.0, 0.0))]).performance.plays[0]
    assert not middle.offset.any()
    assert middle.contact.inner.inner.setup.thickness == 0.0041


def test_an_indenter_stands_elsewhere_all_the_time():
    """An indenter is displaced by the stated sizes in all its touches, another one by another sign or direction."""
    entry = stated("indenter_mount", height=1e-4, aside=2e-4, radius=0.01)
    trajectories = [touch("a"), touch("b", position=(0.0, 0.001)), touch("c", "small"), touch("d", "punch")]
    plays = played([entry], trajectories).performance.plays
    for play in plays:
        assert abs(play.offset[2]) == pytest.approx(1e-4)
        assert np.hypot(*play.offset[:2]) == pytest.approx(2e-4)
    np.testing.assert_array_equal(plays[0].offset, plays[1].offset)
    assert len({tuple(play.offset.round(7)) for play in plays}) == 3
    radius = plays[0].contact.inner.setup.indenter.sizes["radius"]
    assert abs(radius / 0.004 - 1) == pytest.approx(0.01)


def test_stiffening_is_ogdens_in_pure_shear():
    """With s = 0.2 * 0.8 / 1.728 + 0.8 / 12.3 = 0.1576 and e = 0.1715, the factor is 1.163 at exponent 6."""
    assert factor_at_depth(stated("stiffening", exponent=6.0)) == pytest.approx(1.163, abs=0.002)
    assert factor_at_depth(stated("stiffening", exponent=6.0), "small") > 1.17


def test_a_skin_stiffens_small_contacts_more():
    """Gao's function by hand is I = 0.0127 at t / a = 0.05 / 1.728 and nu 0.48, so that the factor is 1 + 5 I."""
    x, nu = 0.05 / 1.728, 0.48
    weight = 2 / np.pi * np.arctan(x)
    weight += ((1 - 2 * nu) * x * np.log((1 + x**2) / x**2) - x / (1 + x**2)) / (2 * np.pi * (1 - nu))
    found = factor_at_depth(stated("skin", thickness=5e-5, ratio=6.0))
    assert found == pytest.approx(1 + 5 * weight, abs=1e-3)
    assert factor_at_depth(stated("skin", thickness=5e-5, ratio=6.0), "small") > found > 1.05


def test_work_softens_below_the_greatest_work_only():
    """A fresh place is loaded as without; the way back is softer, at any speed; the next touch there too, not aside."""
    entry = stated("mullins", loss=0.3)
    _, phases, wrench, _, _ = contact_of([entry])
    _, _, plain, _, _ = contact_of()
    np.testing.assert_allclose(wrench[phases == "press", 2], plain[phases == "press", 2], rtol=1e-12)
    back = (phases == "retreat") & (plain[:, 2] > 0.05) & (plain[:, 2] < 3)
    assert (wrench[back, 2] < 0.9 * plain[back, 2]).all()
    shallow = {"press": {"depth": 0.0004, "settle": 0.05}}
    again = [touch("a"), touch("b", steps=[shallow]), touch("c", steps=[shallow], position=(-0.0055, 0.006))]
    softened, unhurt = peaks(played([entry], again))[1:], peaks(played((), again))[1:]
    assert softened[0] < 0.85 * unhurt[0]
    assert softened[1] == pytest.approx(unhurt[1], rel=1e-3)


def test_wear_grows_with_touches_of_the_place():
    """Wear is n / (n + 10) of 20 % after n touches of the same place, and none far away."""
    trajectories = [touch(f"t{index}") for index in range(4)] + [touch("far", position=(-0.006, 0.006))]
    found = peaks(played([stated("wear", loss=0.2)], trajectories)) / peaks(played((), trajectories))
    np.testing.assert_allclose(found[:4], [1 - 0.2 * n / (n + 10) for n in range(4)], rtol=1e-9)
    assert found[4] == pytest.approx(1.0, abs=1e-4)


def test_a_warm_gel_is_softer_and_higher():
    """After days of power a gel is 10 K warmer, 6 % softer and 12.3 µm higher; right after power-on it is neither."""
    cold = played([stated("warm_up", rise=10.0)], recordings={"tare": "none", "powered": 0.0}).performance.plays[0]
    assert cold.offset[2] == pytest.approx(0.0, abs=5e-8)
    warm = played([stated("warm_up", rise=10.0)], recordings={"tare": "none", "powered": 1e6}).performance.plays[0]
    assert warm.offset[2] == pytest.approx(3e-4 * 0.0041 * 10, rel=1e-6)
    np.testing.assert_allclose(warm.contact.wrench[:, 2], 0.94 * warm.contact.inner.wrench[:, 2], rtol=1e-6)


def test_a_loose_region_is_softer_sideways_there_only():
    """In its middle the first shear meets 1 - share of the stiffness; 8 mm away nothing changes."""
    shear = [PRESS, {"shear": {"by": [0.0002, 0.0]}}]
    for position, left in (((0.0015, 0.002), 0.6), ((0.0, -0.006), 1.0)):
        trajectories = [touch(steps=shear, position=position)]
        found = contact_of([stated("delamination", share=0.4)], trajectories=trajectories)
        plain = contact_of(trajectories=trajectories)
        pulls = [last(contact[2][:, 0], contact[1], "shear") for contact in (found, plain)]
        assert pulls[0] / pulls[1] == pytest.approx(left, rel=2e-3)


def test_a_nearer_border_softens_towards_it():
    """The force falls to 1 - 0.5 exp(-0.5) half a contact radius from it, and hardly at 3.5 radii."""
    half, radius = 0.0184 / 2 - 0.003, np.sqrt(0.0008 * (0.004 - 0.0008 / 3))
    for away, left in ((0.5, 1 - 0.5 * np.exp(-0.5)), (3.5, 1 - 0.5 * np.exp(-3.5))):
        trajectories = [touch(position=(half - away * radius, 0.0))]
        found = peaks(played([stated("pad_edge", inset=0.003)], trajectories)) / peaks(played((), trajectories))
        assert found[0] == pytest.approx(left, rel=2e-3)


def test_relaxation_decays_at_rest_as_a_power_law():
    """In a dwell the force falls by 10^-alpha in a decade, long after loading; nothing pulls, and air is free."""
    dwell = [{"press": {"depth": 0.0008, "step": 0.0008, "speed": 0.02, "settle": 0.0}}, {"dwell": {"time": 12.0}}]
    times, phases, wrench, _, _ = contact_of([stated("relaxation", alpha=0.05)], trajectories=[touch(steps=dwell)])
    start = times[np.flatnonzero(phases == "dwell")[0]]
    early, late = (wrench[np.searchsorted(times, start + seconds), 2] for seconds in (1.0, 10.0))
    assert late / early == pytest.approx(10**-0.05, rel=3e-3)
    assert (wrench[:, 2] >= 0).all()
    assert not wrench[phases == "free"].any()
    plain = contact_of(trajectories=[touch(steps=dwell)])[2][phases == "dwell", 2]
    assert np.ptp(plain) == 0


def test_a_slide_relaxes_where_it_sticks_and_keeps_to_friction_where_it_slides():
    """Slow springs: while it slides the pull is friction times the force; held still it decays as the kernel says."""
    count, rate = 3000, 500.0
    path = np.zeros((count, 2))
    path[:, 0] = np.interp(np.arange(count), [0, 500, 1500], [0.0, 0.0, 2e-3])
    loaded = Loaded(np.full(count, 2.0), np.full(count, 3000.0))
    memory = 0.6 + 0.4 * np.exp(-np.arange(count) / rate / 0.5)
    plain = slide(path, loaded, np.full(count, 1e-5), 0.5, rate)[0][:, 0]
    pull, _, slips = slide(path, loaded, np.full(count, 1e-5), 0.5, rate, SlidingLaws(memory=memory))
    pull = pull[:, 0]
    np.testing.assert_allclose(pull[slips], 1.0, rtol=1e-9)
    assert slips[1200:1499].all()
    assert not slips[1501:].any()
    # it needs a longer way to slide, as what is pulled slowly relaxes on the way
    assert np.flatnonzero(slips)[0] > np.flatnonzero(plain >= 1.0 - 1e-9)[0]
    # no jump where it stops, and never below what is left of a pull that was given long ago
    assert abs(pull[1502] - pull[1499]) < 0.01
    assert 0.6 < pull[-1] < 0.98
    assert (np.diff(pull[1501:]) <= 1e-12).all()


def test_a_memory_that_forgets_nothing_is_none():
    """Sliders that keep all of their pull slide as those without loss do."""
    path = np.cumsum(np.random.default_rng(0).normal(0, 2e-5, (800, 2)), axis=0)
    loaded, areas = Loaded(np.full(800, 1.5), np.full(800, 2500.0)), np.full(800, 1e-5)
    plain = slide(path, loaded, areas, 0.4, 500.0)[0]
    kept = slide(path, loaded, areas, 0.4, 500.0, SlidingLaws(memory=np.ones(800)))[0]
    np.testing.assert_allclose(kept, plain, atol=1e-9)


def test_warm_relaxation_is_faster_when_warm():
    """The same touch days after power-on decays 1 + 0.1 * 12 times as fast on a logarithmic scale."""
    slopes = []
    for powered in (0.0, 1e6):
        _, phases, wrench, _, _ = contact_of(
            [stated("warm_relaxation", alpha=0.02)],
            trajectories=[touch(steps=HELD)],
            recordings={"tare": "none", "powered": powered},
        )
        still = np.flatnonzero(phases == "dwell")
        slopes.append(np.log(wrench[still[0], 2] / wrench[still[-1], 2]))
    assert slopes[1] / slopes[0] == pytest.approx(2.2, rel=0.05)


def test_drainage_is_slower_under_larger_contacts():
    """The half of the share that drains is gone after a time that grows with the contact's area."""
    steps = [{"press": {"depth": 0.0005, "step": 0.0005, "speed": 0.05, "settle": 0.0}}, {"dwell": {"time": 8.0}}]
    half_times = []
    for indenter in ("small", "ball"):
        found = contact_of([stated("drainage", share=0.2)], trajectories=[touch(indenter=indenter, steps=steps)])
        times, phases, wrench, _, play = found
        still = phases == "dwell"
        left = wrench[still, 2] / play.contact.inner.wrench[still, 2]
        half_times.append(times[still][np.searchsorted(-left, -0.9)] - times[still][0])
        assert 0.8 < left[-1] < 0.85
    assert half_times[1] / half_times[0] == pytest.approx(2.0, rel=0.15)


THICK = {"D1": {"background": "digit-bg-0", "gel": {"thickness": 0.2}}}


def test_adhesion_pulls_off_as_jkr_says():
    """The pull on a thick gel is sqrt(8 pi E* W a³) = 0.89 N for a flat punch and 1.5 pi W R = 19 mN for a ball."""
    modulus = 0.9e6 / (1 - 0.48**2)
    slow = [{"press": {"depth": 0.0004, "step": 0.0004}}, {"retreat": {"speed": 0.0002}}]
    for indenter, expected in (
        ("punch", np.sqrt(8 * np.pi * modulus * 0.003**3)),
        ("ball", 1.5 * np.pi * 0.004),
    ):
        trajectories = [touch(indenter=indenter, steps=slow, position=(0.0, 0.0))]
        _, phases, wrench, _, play = contact_of(
            [stated("adhesion", receding=1.0)], trajectories=trajectories, sensors=THICK
        )
        assert -wrench[:, 2].min() == pytest.approx(expected, rel=0.12)
        np.testing.assert_allclose(
            wrench[phases == "press"], play.contact.inner.wrench[phases == "press"], rtol=1e-6, atol=1e-3
        )


def test_adhesion_hardly_survives_shear():
    """The same punch, moved aside by 0.2 mm first, pulls off with sqrt(0.15) of the force."""
    pulls = []
    for steps in ([PRESS], [PRESS, {"shear": {"by": [0.0002, 0.0]}}]):
        trajectories = [touch(indenter="punch", steps=steps)]
        wrench = contact_of([stated("adhesion", receding=1.0)], trajectories=trajectories)[2]
        pulls.append(-wrench[:, 2].min())
    assert pulls[1] / pulls[0] == pytest.approx(np.sqrt(0.15), rel=0.1)


def plateau(entry, by=(0.0016, 0.0), speed=0.001, hidden_friction=0.4, steps=None):
    """|T| / N at the end of a slide, and the contact."""
    shear = {"shear": {"by": list(by), "step": 0.0016, "speed": speed, "settle": 0.0}}
    found = contact_of(
        [entry] if entry else [],
        trajectories=[touch(steps=steps or [PRESS, shear], position=(0.0, 0.0))],
        material={"friction": hidden_friction},
    )
    _, phases, wrench, _, _ = found
    ratio = np.linalg.norm(wrench[:, :2], axis=1) / np.where(wrench[:, 2] > 0, wrench[:, 2], 1.0)
    return ratio[phases == "shear"], found


@pytest.mark.slow
def test_rate_friction_grows_by_its_share_per_decade_while_sliding_only():
    """Half way along the move the speed is 1.5 times its mean: mu (1 + 0.12 log10(1.5 v / v0)); sticking is as ever."""
    entry = stated("rate_friction", per_decade=0.12)
    for speed in (0.0003, 0.003):
        ratio, (_, _, wrench, slipping, play) = plateau(entry, speed=speed)
        middle = len(ratio) // 2
        assert ratio[middle] == pytest.approx(0.4 * (1 + 0.12 * np.log10(1.5 * speed / 1e-3)), rel=0.01)
        np.testing.assert_array_equal(wrench[:, 2], play.contact.inner.wrench[:, 2])
        both_stick = ~slipping & ~play.contact.inner.slipping & (np.cumsum(slipping) == 0)
        np.testing.assert_allclose(wrench[both_stick], play.contact.inner.wrench[both_stick], atol=1e-9)
    factor = HiddenRateFriction(per_decade=0.12).friction(None)
    assert factor(Slide(1e-3, 0.0, 0.0, 0.0)) == pytest.approx(1.0, abs=1e-6)


def test_ageing_friction_peaks_at_the_onset_and_more_after_a_longer_rest():
    """The first slip needs more than the later sliding; 1 + b ln(1 + age / 0.03 s) bounds it."""
    entry = stated("ageing_friction", growth=0.05)
    tops = []
    for rest in (0.2, 5.0):
        shear = {"shear": {"by": [0.0016, 0.0], "step": 0.0016, "speed": 0.001, "settle": 0.0}}
        ratio, _ = plateau(entry, steps=[PRESS, {"dwell": {"time": rest}}, shear])
        tops.append(ratio.max())
        assert ratio[len(ratio) * 3 // 4] < 0.98 * ratio.max()
    assert tops[1] > tops[0] > 0.4
    assert tops[1] < 0.4 * (1 + 0.05 * np.log(1 + 8 / 0.03))


def test_shear_strength_limits_the_pull():
    """The pull is A tau tanh(mu N / (A tau)), with the area of the contact by hand."""
    ratio, (_, phases, wrench, _, _) = plateau(stated("shear_strength", softness=1 / 0.2e6), hidden_friction=0.8)
    area = np.pi * 0.0008 * (0.004 - 0.0008 / 3)
    normal = last(wrench[:, 2], phases, "shear")
    assert ratio.max() * normal == pytest.approx(area * 0.2e6 * np.tanh(0.8 * normal / (area * 0.2e6)), rel=0.01)


def test_many_sliders_give_way_part_by_part():
    """Sliders have the same first stiffness and plateau and less between: half the limit is reached as without."""
    ratio, _ = plateau(stated("partial_slip", width=1.0))
    plain, _ = plateau(None)
    first = np.flatnonzero(plain > 0.01 * 0.4)[0]
    assert ratio[first] == pytest.approx(plain[first], rel=0.02)
    assert ratio[-1] == pytest.approx(0.4, rel=1e-6)
    knee = np.flatnonzero(plain > 0.95 * 0.4)[0]
    assert ratio[knee] == pytest.approx(0.75 * 0.4, rel=0.06)


def test_anisotropic_friction_differs_between_the_axes():
    """1 + share along x, 1 - share along y; the normal force does not know."""
    entry = stated("anisotropy", share=0.2)
    along, (_, _, wrench, _, play) = plateau(entry)
    across, _ = plateau(entry, by=(0.0, 0.0016))
    assert along[-1] == pytest.approx(0.4 * 1.2, rel=1e-3)
    assert across[-1] == pytest.approx(0.4 * 0.8, rel=1e-3)
    np.testing.assert_array_equal(wrench[:, 2], play.contact.inner.wrench[:, 2])


def test_sliders_without_factors_are_coulombs():
    """The slow path of hidden friction and the rig's plain stick-slip agree."""
    rng = np.random.default_rng(0)
    path = np.cumsum(rng.normal(0.0, 2e-5, (400, 2)), axis=0)
    normal = np.clip(np.sin(np.arange(400) / 30.0), 0.0, None) * 5
    stiffness = np.where(normal > 0, 4000.0, 0.0)
    plain, plain_slips = stick_slip(path, normal, stiffness, 0.5)
    pull, limit, slips = slide(path, Loaded(normal, stiffness), np.full(400, 1e-5), 0.5, CONTACT_RATE)
    np.testing.assert_allclose(pull, plain, atol=1e-12)
    np.testing.assert_array_equal(slips[normal > 0], plain_slips[normal > 0])
    assert (np.linalg.norm(pull, axis=1) <= limit + 1e-12).all()


def facts_of(play, scenario):
    """What an effect would be told of a touch."""
    from tactiledata.rig.hidden.base import TouchFacts
    from tactiledata.rig.play import RigSetup

    mounted = RigSetup(scenario).mounted[play.touch.indenter]
    return TouchFacts(play.touch, scenario, 0.0, 1, 0, mounted, [])


def test_arm_compliance_is_that_of_the_joints():
    """C from differences of the forward kinematics; what is missed is C F, and the force falls accordingly."""
    entry = stated("arm_compliance", softness=1 / 20e3)
    _, _, wrench, _, play = contact_of([entry], trajectories=[touch(indenter="punch", steps=PUSHED)])
    scenario = world([entry], [touch(indenter="punch", steps=PUSHED)])
    setup, facts = play.contact.inner.setup, facts_of(play, scenario)
    give = HiddenJointCompliance(1 / 20e3).compliance(play.path, setup, facts)
    deepest = play.path.positions[[int(np.argmax(play.path.positions[:, 2]))]]
    base_from_gel = sensor_poses(deepest, setup, facts)[0]
    flange_from_gel = (scenario.robot.flange_from_tcp @ scenario.robot.tcp_from_gel).matrix
    joints = ur5e.inverse(base_from_gel @ np.linalg.inv(flange_from_gel))[0]
    moves = np.empty((3, 6))
    for joint in range(6):
        two = joints + np.outer([1.0, -1.0], 1e-6 * np.eye(6)[joint])
        ends = (ur5e.forward(two) @ flange_from_gel)[:, :3, 3]
        moves[:, joint] = base_from_gel[:3, :3].T @ (ends[0] - ends[1]) / 2e-6
    stiffness = 20e3 * np.array([1.0, 1.0, 1.0, 0.4, 0.4, 0.4])
    np.testing.assert_allclose(give, moves / stiffness @ moves.T, rtol=1e-5)
    assert 3e-6 < give[2, 2] < 3e-5
    asked = wrench[:, :3] @ give.T * [1.0, 1.0, -1.0]
    np.testing.assert_allclose(play.contact.deviation, asked, atol=2e-7)
    assert wrench[:, 2].max() < 0.95 * play.contact.inner.setup.touch.force_limit


def test_a_stem_is_a_spring_in_series_sideways():
    """1 / k = 1 / k0 + L³ / (3 E I) for the first shear; straight presses do not bend it."""
    steps = [PRESS, {"shear": {"by": [0.0002, 0.0], "settle": 0.0}}]
    entry = stated("stem_bending", softness=1 / 0.006)
    trajectories = [touch(steps=steps)]
    _, phases, wrench, _, _ = contact_of([entry], trajectories=trajectories)
    _, _, plain, _, _ = contact_of(trajectories=trajectories)
    np.testing.assert_allclose(wrench[:, 2], plain[:, 2], atol=1e-6)
    beam = 3 * 2.5e9 * np.pi * 0.006**4 / 64 / 0.03**3
    rigid = -last(plain[:, 0], phases, "shear") / 0.0002
    assert -last(wrench[:, 0], phases, "shear") / 0.0002 == pytest.approx(1 / (1 / rigid + 1 / beam), rel=1e-3)


def test_backlash_is_a_play_of_the_joints():
    """A joint is at most half the play from the encoder, unmoved within it; a touch misses by a lever's worth."""
    angles = np.linspace(0.0, 1e-3, 50)[:, None] * np.ones(6)
    there_and_back = np.concatenate([angles, angles[::-1]])
    out = followed(there_and_back, 2e-4)
    assert np.abs(out - there_and_back).max() <= 1e-4 + 1e-12
    np.testing.assert_allclose(out[50 : 50 + 9], out[49:50].repeat(9, axis=0), atol=3e-5)
    deviation = contact_of([stated("joint_backlash", play=1e-4)])[4].contact.deviation
    assert 1e-6 < np.abs(deviation).max() < 6 * 0.5e-4


@pytest.mark.slow
def test_a_slide_of_the_layer_solver_takes_hidden_effects_too():
    """Relaxation and yielding act on the layer's own forces, with a balance within half a micrometre."""
    steps = [{"press": {"depth": 0.0004, "step": 0.0004, "settle": 0.0}}, {"dwell": {"time": 0.5}}]
    found = contact_of(
        [stated("arm_compliance", softness=1 / 20e3), stated("relaxation", alpha=0.05)],
        trajectories=[touch(steps=steps, position=(0.0, 0.0))],
        contact="layer",
        contact_pitch=0.001,
    )
    _, phases, wrench, _, play = found
    inner = play.contact.inner.wrench
    assert type(play.contact.inner).__name__ == "LayerContact"
    still = np.flatnonzero(phases == "dwell")
    assert np.ptp(inner[still, 2]) < 1e-6
    assert 0.8 < wrench[still[-1], 2] / inner[still[-1], 2] < wrench[still[0], 2] / inner[still[0], 2] < 1.0
    assert play.contact.unbalanced < 1e-6


@pytest.mark.slow
def test_an_effect_of_next_to_no_strength_leaves_a_slide_as_it_is():
    """What slides on flanks pulls a little more than friction of its normal force: no effect takes that away."""
    changes = {"trajectories": [touch(steps=[PRESS, SLIDE])], "contact": "layer", "contact_pitch": 0.001}
    _, _, plain, _, _ = contact_of(**changes)
    beyond = np.linalg.norm(plain[:, :2], axis=1) - 0.8 * plain[:, 2]
    assert beyond.max() > 0.02
    _, _, wrench, _, _ = contact_of([stated("relaxation", alpha=1e-7)], **changes)
    np.testing.assert_allclose(wrench, plain, atol=1e-4)
