"""Whether a sensor that pictures are transferred to has been seen before, by the store or by a model."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from tactiledata.arrays import PictureArray
from tactiledata.contract.records import Finding
from tactiledata.sensors.same_sensor import is_same_sensor
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import Target


def target_findings(
    target: Target, store: Store, sources: Collection[str], learned: Sequence[tuple[str, PictureArray]] | None = None
) -> list[Finding]:
    """Warnings where a target's picture is that of a sensor of the store, or of one that the model was trained on.

    Parameters
    ----------
    target : Target
    store : Store
        Whose touches are transferred. A target that is a sensor of the store by name is asked for, and no warning
        unless its own touches are transferred too.
    sources : collection of str
        Sensors whose touches are transferred.
    learned : list of (str, (H, W, 3) uint8), optional
        Names and pictures without contact of the sensors that the model was trained on; empty where the model does not
        say; None where there is no model.
    """
    held = {
        sensor: reference.image
        for sensor, reference in store.references().items()
        if sensor in sources or sensor != target.name
    }
    return [*_in_store(target, held), *_of_model(target, learned)]


def _in_store(target: Target, held: dict[str, PictureArray]) -> list[Finding]:
    same = [sensor for sensor, picture in held.items() if is_same_sensor(picture, target.background)]
    if not same:
        return []
    text = (
        f"the picture of {target.name} without contact is that of {', '.join(same)} of this store: this is no transfer "
        "to a sensor that the store has not seen. For one of those, name another target"
    )
    return [Finding("target-in-store", "warning", text, stream=target.name)]


def _of_model(target: Target, learned: Sequence[tuple[str, PictureArray]] | None) -> list[Finding]:
    if learned is None:
        return []
    if not learned:
        text = "the model does not say which sensors it was trained on: whether it has seen the target cannot be told"
        return [Finding("model-sensors-unknown", "info", text, stream=target.name)]
    same = [name for name, picture in learned if is_same_sensor(picture, target.background)]
    if not same:
        return []
    names = ", ".join(dict.fromkeys(same))
    text = (
        f"the picture of {target.name} without contact is that of {names}, which the model was trained on: scores of "
        "this transfer say nothing about a sensor that the model has not seen"
    )
    return [Finding("target-in-training", "warning", text, stream=target.name)]
