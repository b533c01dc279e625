"""How much better the simulation becomes on data that had no part in the fit.

Read the modules in this order:

- `touch_residuals`: which residuals does a fit leave, in the form that locators, formulas and black box ask for?
- `errors`: how large are the errors of force and torque on trajectories, indenters and sensors that were held out?
- `compare`: what do the named effects change on these, and what is left with them?

A fit is refitted without the held-out group to first order; the held-out wrenches are then played by the simulation.
This room imports `touches`, `naming`, `locate` and `residuals`. It writes no sentences: `answer` does.
"""
