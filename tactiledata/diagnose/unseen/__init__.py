"""How much better the simulation becomes on data that had no part in the fit."""
