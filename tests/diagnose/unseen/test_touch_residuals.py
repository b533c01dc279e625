"""What effects change in touches: each of these fields has a name of its own."""

from touch_worlds import START, null

from tactiledata.diagnose.naming.joint_fit import joint_fit
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.unseen.touch_residuals import signature_fields

EFFECTS = ("quantisation", "clipping", "lag")


def test_every_size_of_an_effect_is_compared():
    """An effect that acts from a threshold on has a field of changes for each size that is tried; others have one."""
    white = WhitenedTouches.of(null(3000, trajectories=4))
    fit = joint_fit(white, joint_model(START, [], 4, len(white.simulation_errors)))
    taken = {
        (signature.effect, *signature.shapes.values(), strength.label, float(size))
        for signature in effect_signatures(white, fit.model.material, EFFECTS, (), fit.model.offsets)
        for strength, size in zip(signature.strengths, signature.step_sizes, strict=True)
    }
    names = list(signature_fields(white, fit, EFFECTS))
    assert len(names) == len(taken)
    bands = [name for name in names if "(dead_band" in name and "torque_noise 0.002" in name]
    assert [name.partition(" at ")[2].partition(",")[0] for name in bands] == [
        f"{size:g} N" for size in (0.1, 0.15, 0.2, 0.25, 0.35, 0.5)
    ]
    assert len([name for name in names if name.startswith("lag")]) == 2
