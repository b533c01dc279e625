"""Diagnosis: where recordings and simulation differ, which physics the simulation lacks, and what to record next.

Two verbs. ``store.diagnose_store`` diagnoses a store, for which the gel is simulated. ``table.diagnose_table``
diagnoses a table of observations and predictions, without a gel. ``options`` holds what a user can choose for a store.

What a store passes through, room by room, in the order of ``diagnose_store``:

1. ``touches``: the measured touches, each simulated over a grid of parameters, as whitened residuals.
2. ``naming``: which effect of the catalogue is missing: screening, joint refits, held-out evidence, decision.
3. ``locate``: where the plain simulation differs, and the one with the named effects; ``unseen`` calls it.
4. ``unseen``: how much smaller the errors become on trajectories and indenters that had no part in the fit.
5. ``formula``: a formula of the covariates, where physics is missing and no effect of the catalogue fits.
6. ``next_trial``: what these recordings cannot determine, and the touches that would separate the explanations.
7. ``zeros``: what the zero of the force sensor follows, from its readings in free air.
8. ``answer``: the verdict on the store, sentences, pages and documents; no other room writes a page or a JSON document.

A table passes through ``table_input`` (columns as residuals), ``formula`` (which runs ``locate``) and ``answer``.
``residuals`` holds the statistics that all these rooms share: their sampling unit is a whole trajectory. ``verdict``
has the only words that a verdict may be.
"""
