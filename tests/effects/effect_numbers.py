"""The page of the numbers of all effects, docs/effect-numbers.md.

``python tests/effects/effect_numbers.py`` writes it.
"""

from pathlib import Path

from tactiledata.effects import EFFECTS

PAGE = Path(__file__).parents[2] / "docs" / "effect-numbers.md"
HEAD = """# The numbers of effects

Every number that a diagnosis takes for granted of an effect, before it has seen a recording.
The page is written from the code by `python tests/effects/effect_numbers.py`; a test compares both.
Another number changes diagnoses: it needs a source, and a decision in [decisions](decisions) that says why.

- **default**: the value where nobody states one; a strength is 0, so that the effect is absent.
- **bounds**: what a fit may try and a setting may hold. **plausible**: what can be believed on such a rig; a fit
  farther out than twice that points at another cause.
- **deviation**: standard deviation of the normal prior of a strength about 0. A shape has none: its prior is flat.
- **grid**: values of a shape that a screen tries; of a strength that acts from a threshold on, sizes at which it looks.

| effect | parameter | unit | default | bounds | plausible | deviation | grid | source |
|---|---|---|---|---|---|---|---|---|
"""


def number(value):
    """A number with all the digits that it was written with."""
    return f"{value:.12g}"


def row(name, parameter):
    """A row of the table."""
    deviation = "flat" if parameter.deviation is None else number(parameter.deviation)
    cells = [
        f"`{name}`",
        f"`{parameter.name}`",
        parameter.unit,
        number(parameter.default),
        " … ".join(map(number, parameter.bounds)),
        " … ".join(map(number, parameter.plausible)),
        deviation,
        ", ".join(map(number, parameter.grid)),
        parameter.source.replace("|", "/"),
    ]
    return f"| {' | '.join(cells)} |"


def page():
    """The whole page."""
    rows = [row(name, parameter) for name in EFFECTS for parameter in EFFECTS[name]().parameters]
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
