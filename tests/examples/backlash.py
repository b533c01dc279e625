"""An effect of one's own: play of the wrist, by which the tip stands higher once it presses."""

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength


class Backlash(Effect):
    """The tip stands higher by ``gap`` in every frame in which it presses.

    Source: geometry of a joint with play under a load of one sign.
    """

    name = "backlash"
    title = "play of the wrist"
    slot = "pose"
    parameters = (
        strength(
            "gap",
            "m",
            "how far the tip yields before it holds",
            bounds=(0.0, 1e-3),
            plausible=(0.0, 1e-4),
            deviation=3e-5,
            source="estimate",
        ),
    )
    look_alikes = ("mount_offset", "arm_compliance")
    distinguishing_trial = "Press on a steel block: the force begins later by the gap, then rises as steeply as ever."
    detectability = "0.05 mm is 0.3 to 0.7 N."
    reference = "geometry"

    def change(self, state, values):
        """Higher by the gap where the recorded touch presses."""
        return state.moved(deeper=-values["gap"] * (state.contact.wrench[:, 2] > 0))
