"""The clock of the force sensor runs at another rate than that of the camera."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.earlier_places import delayed_along
from tactiledata.effects.touch.state import TouchState


class ClockSkew(Effect):
    """A delay of the wrench, F(t) -> F(t - delay): delay = rate t, plus ``jump`` from the time ``jump_at`` on.

    t is the time since the start of the recording. Between frames the wrench follows the path of the tip, where that is
    known.

    Source: quartz clocks differ by 10 to 100 ppm, 0.6 to 6 ms a minute; a dropped frame shifts all later ones by
    one.
    """

    name = "clock_skew"
    title = "clock skew and dropped frames"
    slot = "time"
    parameters = (
        strength(
            "rate", "1", "seconds of delay per second of recording",
            bounds=(-5e-3, 5e-3), plausible=(-5e-4, 5e-4), deviation=5e-5,
            source="10 to 100 ppm of quartz clocks, 500 ppm and more of ceramic resonators",
        ),
        strength(
            "jump", "s", "delay from a moment on",
            bounds=(-0.5, 0.5), plausible=(-0.04, 0.04), deviation=0.017, source="one frame at 25 to 60 Hz",
        ),
        shape(
            "jump_at", "s", "moment of the jump, since the start of the recording",
            default=0.0, bounds=(0.0, 1e5), grid=(60.0, 300.0, 900.0), source="anywhere in the recording",
        ),
    )  # fmt: skip
    look_alikes = ("lag", "relaxation")
    distinguishing_trial = (
        "A tap at the start and at the end of one recording: the lag between them grows, and starts anew with the file."
    )
    detectability = "50 ppm are 30 ms after ten minutes: 0.3 N where the force changes by 10 N/s."
    reference = "oscillator tolerances"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        seconds = state.touch.seconds
        delay = values["rate"] * seconds + np.where(seconds >= values["jump_at"], values["jump"], 0.0)
        late = delayed_along(seconds, state.wrench, state.touch.tips, state.touch.earlier_places, delay)
        return state.with_reading(late)
