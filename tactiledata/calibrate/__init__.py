"""Calibration: which E, nu and mu (friction) a gel has by measured wrenches, and how well they are known.

Read in this order:

- ``options``, ``bounds``, ``gent``: what a user chooses, the box that is searched, the start of the search;
- ``measured``, ``touches``: which trajectories of a store can be used, and why others cannot;
- ``plan``: at which parameters the gel is simulated; ``plays``: the simulated touches, kept on disk, and those that are
  estimated from others and from the linear engine;
- ``response``, ``experiment``: simulated wrenches interpolated at any parameters, beside the measured ones;
- ``losses``, ``search``, ``least_squares``, ``fit``: the distance between the two, and its minimum;
- ``corrected_fit``: the fit again, with interpolated forces corrected by simulations at the optimum;
- ``intervals``, ``simulation_error``, ``coverage``: how well the parameters are known, and how often that is true;
  ``knowledge``: whether each is identified, bounded or not told by the data;
- ``calibrate``: all steps in a row; ``remarks``, ``document``, ``surface``, ``page``: the result for a reader.

The room simulates through ``gel`` and takes its noise models from ``nuisance``. It writes no store, and it does not
ask which physics is missing: that is ``diagnose``.
"""
