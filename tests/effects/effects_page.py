"""Rows of the page of effects, docs/effects.md, as the classes have them.

``python tests/effects/effects_page.py`` writes them, and docs/effect-numbers.md.
"""

from pathlib import Path

import effect_numbers

from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.reference_touch import largest_changes

PAGE = Path(__file__).parents[2] / "docs" / "effects.md"
TABLE = "| effect | slot | what it is | parameters | looks like |\n|---|---|---|---|---|\n"
TRIALS = "## What can be seen, and what separates them\n\n"


def row(name):
    """The row of an effect in the table: slot, parameters with sizes on the reference touch, look-alikes."""
    effect = EFFECTS[name]()
    changes = largest_changes(effect)
    parts = []
    for parameter in effect.parameters:
        low, high = parameter.plausible
        size = changes.get(parameter.name, 0.0)
        shown = f": {size:.2g} N" if size >= 1e-3 else ""
        parts.append(f"`{parameter.name}` [{parameter.unit}] {low:g} … {high:g}{shown}")
    listed = ", ".join(f"`{other}`" for other in effect.look_alikes)
    return f"| `{name}` | {effect.slot} | {effect.title} | {'; '.join(parts)} | {listed} |"


def trial(name):
    """The line of an effect: what can be seen of it, what separates it, what it needs, and what else acts alike."""
    effect = EFFECTS[name]
    needs = f" Needs {', '.join(f'`{field}`' for field in effect.needs)}." if effect.needs else ""
    outside = f" Outside the catalogue: {effect.unlisted_look_alike}." if effect.unlisted_look_alike else ""
    return f"- `{name}`: {effect.detectability} *{effect.distinguishing_trial}*{needs}{outside}"


def page(text):
    """The page with the rows and lines of all effects of this package, in the order of the table."""
    for head, written in ((TABLE, row), (TRIALS, trial)):
        before, _, rest = text.partition(head)
        after = rest.partition("\n\n")[2]
        text = f"{before}{head}" + "\n".join(map(written, EFFECTS._table)) + f"\n\n{after}"
    return text


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    effect_numbers.PAGE.write_text(effect_numbers.page(), encoding="utf-8")
