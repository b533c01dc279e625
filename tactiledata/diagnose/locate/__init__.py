"""Where recordings and simulation differ: locators, each a statistical test of one form of difference, one in a file.

The question: on which covariate, label, event, place or time does the residual, or a parameter, depend? A locator gets
`Residuals` or their projection and returns findings with a p-value, a size with interval and a clause in words.

Read ``locate`` first: it runs every locator and corrects the p-values for their number (Holm). Then, by what is asked:

- anything at all: ``gate`` (is the residual larger or slower than noise?), ``energy`` (which data hold the excess?);
- before contact: ``free_air`` (zeros of the sensor);
- a parameter: ``common_offset`` (wrong everywhere), ``drifts`` (changes with a covariate), ``leading_drifts`` (drifts
  that remain once stronger ones are fitted), ``own_offsets`` (what the values of single trajectories follow),
  ``steps`` (jumps between trajectories), ``region_map`` (depends on the place on the gel);
- an event: ``events`` (finds them in labels), ``event_locked`` (mean about an event), ``event_effects`` (a departure
  from an event on, fitted together with the parameters);
- any form: ``contrasts`` (components and parameters along all covariates, where the simulator's errors are known),
  ``tree`` (conditions grown on one half of the trajectories and tested on the other).

A new locator is one file with a `base.Locator`, and one line in the table below. ``simulator_errors`` raises the
p-value of findings that errors of the simulation could explain. The room imports ``residuals`` only; it names no
effect and writes no page.
"""

from __future__ import annotations

from tactiledata.registry import Registry

LOCATORS = Registry(
    "locator",
    {
        "common_offset": "tactiledata.diagnose.locate.common_offset:LOCATOR",
        "event_effects": "tactiledata.diagnose.locate.event_effects:LOCATOR",
        "steps": "tactiledata.diagnose.locate.steps:LOCATOR",
        "tree": "tactiledata.diagnose.locate.tree:LOCATOR",
    },
    group="tactiledata.locators",
)
"""Locators whose findings are said and listed, and on which nothing else rests.

The others, whose findings pages draw or further tests need, are called by `locate.locate` itself.
"""
