"""The trials that can be proposed: each takes some minutes and changes one cause while the others stay.

All have about 200 to 300 frames, so that none wins by the number of its frames.

A trial is made for a `TrialBench`: the recorded rig with the fitted gel. "The ball" is its ball nearest to 4 mm radius.
"The depth" of an indenter is `TrialBench.depth`: the deepest press that keeps force and depth within their limits.
Places lie on the pad. An indenter that is not at hand is proposed as one to be made, and a domed gel counts as flat.
"""

from __future__ import annotations

from collections.abc import Callable

from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.trial import Trial, TrialTouch, dwell, press, retreat, shear, turn

SLOW, USUAL, QUICK = 5e-4, 1e-3, 3e-3
"""Speeds, m/s."""
SLIDE = 2e-3
"""Length of a slide, m: longer than any stick."""
STEPS = 6
"""Steps of a press."""


def hold(bench: TrialBench) -> Trial:
    """Return a press of the ball to its depth at 3 mm/s, held for 60 s: it shows what changes without motion.

    The depth is `TrialBench.depth`. Made to tell relaxation from a lag of the force sensor.
    """
    depth = bench.depth(bench.ball)
    held = (dwell(2.0, 60), dwell(8.0, 80), dwell(50.0, 100))
    touch = TrialTouch(bench.ball, (press(depth, QUICK, settle=0.0), *held, retreat(USUAL)))
    return Trial("hold", f"Press quickly to {_mm(depth)} and hold for 60 s", (touch,), burst=8)


def rate_ladder(bench: TrialBench) -> Trial:
    """Return presses of the ball to its depth and back, at 0.1, 0.3, 1 and 3 mm/s: they show what depends on rate.

    The depth is `TrialBench.depth`. Made for relaxation and lags of the force sensor.
    """
    depth = bench.depth(bench.ball)
    speeds = (1e-4, 3e-4, 1e-3, 3e-3)
    touches = tuple(TrialTouch(bench.ball, (press(depth, v), retreat(v))) for v in speeds)
    return Trial("rate_ladder", f"Press to {_mm(depth)} and leave at 0.1, 0.3, 1 and 3 mm/s", touches, "video")


def load_unload_reload(bench: TrialBench) -> Trial:
    """Return one touch of the ball at a fresh spot: loaded to 0.7 of its depth twice, then to all of it.

    It shows what the first loading changes. Each load is taken off down to 0.05 of the depth, at 0.5 mm/s in steps.
    Made to tell softening by the first stretch (Mullins) from relaxation.
    """
    depth = bench.depth(bench.ball)
    ways = [press(share * depth, SLOW, depth / STEPS, 0.3) for share in (0.7, 0.05, 0.7, 0.05, 1.0, 0.05)]
    (spot,) = bench.fresh(bench.ball, 1)
    touch = TrialTouch(bench.ball, (*ways, retreat(SLOW)), spot)
    title = f"Load to {_mm(0.7 * depth)}, unload and load again at a fresh spot, then to {_mm(depth)}"
    return Trial("load_unload_reload", title, (touch,), burst=9)


def first_touches(bench: TrialBench) -> Trial:
    """Return three presses of the ball at each of two fresh spots: they show how a touch changes the next ones.

    Each goes to the depth in six steps, at 1 mm/s. Made for softening by earlier touches (Mullins) and wear.
    """
    touches = tuple(_press(bench, bench.ball, spot) for spot in bench.fresh(bench.ball, 2) for _ in range(3))
    title = f"Press {_mm(bench.depth(bench.ball))} three times at each of two fresh spots"
    return Trial("first_touches", title, touches, burst=5)


def turns(bench: TrialBench) -> Trial:
    """Return turns in free air: gravity changes its direction in the sensor's frame, and nothing touches.

    They are of half a radian to each side about x and y of the gel, and of one radian to each side about z, then back.
    Made to tell a tool's weight and the pull of a cable from a drift of the zero.
    """
    ways = [(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, -0.5, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    touch = TrialTouch(bench.ball, (*(turn(*way) for way in ways), turn(0.0, 0.0, 0.0)))
    caveat = "The estimate takes only the last joint to follow a turn about the gel's normal."
    return Trial(
        "turns", "Turn the sensor in free air, half a radian to each side", (touch,), "video", 8.0, caveat=caveat
    )


def starts_and_stops(bench: TrialBench) -> Trial:
    """Return eight moves of 10 mm at 50 mm/s in free air: their starts and stops show what accelerations do.

    They go there and back along x, 20 mm above the gel. Made to tell inertia from a lag of the force sensor.
    """
    ways = [shear(sign * 0.01, 0.0, 0.05, settle=0.3) for sign in (1.0, -1.0) * 4]
    touch = TrialTouch(bench.ball, (turn(0.0, 0.0, 0.0, 0.5), *ways))
    return Trial("starts_and_stops", "Start and stop in free air, 10 mm at 50 mm/s", (touch,), "video", 20.0)


def flat_punch(bench: TrialBench) -> Trial:
    """Return presses of a flat punch to 0.4, 0.7 and 1 times its depth, each left slowly.

    The area of a flat punch does not grow with depth. Its force follows another law over depth than a ball's, and what
    can hide in one law shows beside the other: gains of the force sensor, and the arm's compliance. The punch goes down
    at 0.5 mm/s, rests for 2 s, goes back to 0.01 mm of depth and leaves at 0.1 mm/s, because adhesion shows as a pull
    while the gel lets go.
    """
    depth = bench.depth(bench.punch)
    touches = tuple(
        TrialTouch(bench.punch, (press(share * depth, SLOW), dwell(2.0, 4), press(0.01e-3, 1e-4), retreat(1e-4)))
        for share in (0.4, 0.7, 1.0)
    )
    title = f"Press a flat punch to {_mm(0.4 * depth)}, {_mm(0.7 * depth)} and {_mm(depth)} and leave slowly"
    caveat = "On a block of steel in place of the gel only the arm would yield; the rig has none."
    return Trial("flat_punch", title, touches, "video", caveat=caveat)


def five_places(bench: TrialBench) -> Trial:
    """Return a press of the ball in the middle of the pad and near each of its four borders.

    They show what depends on the place. Each goes to the depth in six steps, at 1 mm/s. Made for the curvature of the
    gel, its border and soft spots.
    """
    x, y = (round(side, 5) for side in bench.reach(bench.ball))
    places = [(0.0, 0.0), (x, 0.0), (-x, 0.0), (0.0, y), (0.0, -y)]
    title = f"Press {_mm(bench.depth(bench.ball))} in the middle and near each border"
    return Trial("five_places", title, tuple(_press(bench, bench.ball, place) for place in places), burst=7)


def from_power_on(bench: TrialBench) -> Trial:
    """Return one press of the ball every four minutes from power-on, seven in all, then two after a new power-on.

    They show warming: the sensor cools while it is off. Made to tell heating from wear.
    """
    title = (
        f"Press {_mm(bench.depth(bench.ball))} every 4 min from power-on for half an hour; switch off, let it cool,"
        " and press twice more"
    )
    touch = _press(bench, bench.ball)
    return Trial("from_power_on", title, (touch,) * 9, burst=4, pause=240.0, powered=20.0, per_recording=7)


def slides(bench: TrialBench) -> Trial:
    """Return slides of 2 mm at 0.3, 1 and 5 mm/s under each of three loads: they show the law of friction.

    The loads are the ball's at 0.5, 0.75 and 1 times its depth (`TrialBench.depth`). It slides along x, back, and along
    x again. Made for friction that depends on speed or area, and for static friction.
    """
    depth = bench.depth(bench.ball)
    ways = (shear(SLIDE, 0.0, 3e-4), shear(-SLIDE, 0.0, 1e-3), shear(SLIDE, 0.0, 5e-3))
    touches = tuple(
        TrialTouch(bench.ball, (press(share * depth, USUAL), *ways, retreat(USUAL)), (-SLIDE / 2, 0.0))
        for share in (0.5, 0.75, 1.0)
    )
    return Trial("slides", "Slide 2 mm at 0.3, 1 and 5 mm/s under each of three loads", touches, "video", 8.0)


def hold_then_slide(bench: TrialBench) -> Trial:
    """Return three touches of the ball, held for 1, 10 and 100 s before a slide: they show how friction grows at rest.

    They go to 0.75 of the depth (`TrialBench.depth`) at 1 mm/s, slide by 2 mm along x at 0.5 mm/s, and leave the gel.
    Made for the ageing of a resting contact.
    """
    depth = 0.75 * bench.depth(bench.ball)
    touches = tuple(
        TrialTouch(
            bench.ball,
            (press(depth, USUAL), dwell(held, 4), shear(SLIDE, 0.0, SLOW, SLIDE / 20), dwell(1.0, 1)),
            (-SLIDE / 2, 0.0),
        )
        for held in (1.0, 10.0, 100.0)
    )
    return Trial("hold_then_slide", "Hold for 1, 10 and 100 s, then slide 2 mm", touches, burst=4)


def shear_and_back(bench: TrialBench) -> Trial:
    """Return one touch of the ball with shear by 0.2 and 0.4 mm to both sides and back: it shows hysteresis.

    It shears along x, and stays below sliding, at 0.5 mm/s and the full depth (`TrialBench.depth`). Made for partial
    slip, the stem's bending and dead bands.
    """
    depth = bench.depth(bench.ball)
    ways = [shear(sign * size, 0.0, SLOW, size / 4, 0.1) for size in (2e-4, 4e-4) for sign in (1.0, -2.0, 1.0)]
    touch = TrialTouch(bench.ball, (press(depth, USUAL), *ways, dwell(1.0, 2), retreat(USUAL)))
    return Trial("shear_and_back", "Shear by 0.2 and 0.4 mm to both sides and return to zero", (touch,), burst=7)


def three_depths(bench: TrialBench) -> Trial:
    """Return presses of the ball to 0.4, 0.7 and 1 times its depth: they show what depends on strain.

    Made for stiffening at large strain, the gel's thickness and its coating.
    """
    title = f"Press to 0.4, 0.7 and 1 times {_mm(bench.depth(bench.ball))}"
    return Trial("three_depths", title, _depths(bench, bench.ball), burst=16)


def three_radii(bench: TrialBench) -> Trial:
    """Return presses of balls of about 2, 4 and 8 mm radius, each to 0.4, 0.7 and 1 times its own depth.

    They separate the gel's thickness, its coating and stiffening at large strain, which one ball shows alike.
    """
    touches = tuple(touch for name in bench.balls for touch in _depths(bench, name))
    sizes = ", ".join(f"{1e3 * bench.indenter(name).sizes['radius']:g}" for name in bench.balls)
    return Trial("three_radii", f"Press balls of {sizes} mm radius to three depths each", touches, burst=5)


def taps(bench: TrialBench) -> Trial:
    """Return a tap of the ball at the start of a recording and one ten minutes later: they show how clocks run.

    Both go to the depth (`TrialBench.depth`) and back at 3 mm/s. Made to tell clocks that run at different rates from a
    lag.
    """
    touch = TrialTouch(bench.ball, (press(bench.depth(bench.ball), QUICK, settle=1.0), retreat(QUICK)))
    return Trial("taps", "Tap at the start and ten minutes later in one recording", (touch,) * 2, burst=40, pause=600.0)


def _press(bench: TrialBench, name: str, place: tuple[float, float] = (0.0, 0.0), share: float = 1.0) -> TrialTouch:
    """Return a stepwise press of an indenter to a share of its depth, at a place (x, y), m."""
    depth = share * bench.depth(name)
    return TrialTouch(name, (press(depth, USUAL, depth / STEPS, 0.2), dwell(0.5, 1), retreat(USUAL)), place)


def _depths(bench: TrialBench, name: str) -> tuple[TrialTouch, ...]:
    """Return presses of an indenter to 0.4, 0.7 and 1 times its depth."""
    return tuple(_press(bench, name, share=share) for share in (0.4, 0.7, 1.0))


def _mm(depth: float) -> str:
    return f"{1e3 * depth:.2f} mm"


TRIALS: tuple[Callable[[TrialBench], Trial], ...] = (
    hold, rate_ladder, load_unload_reload, first_touches, turns, starts_and_stops, flat_punch, five_places,
    from_power_on, slides, hold_then_slide, shear_and_back, three_depths, three_radii, taps,
)  # fmt: skip
"""All trials that can be proposed."""
