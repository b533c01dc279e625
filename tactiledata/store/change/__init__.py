"""A store that is merged, corrected, or given a sensor.

- ``pieces``: one source of a store as what it was when it came; ``merge`` and ``replace`` start from these.
- ``merge``: several stores into one; each source is committed as if it had been ingested there.
- ``replace``: recordings replaced by corrected ones in one commit; pictures that stay are not moved.
- ``add_sensor``: a sensor added by hand, with its picture without contact.
- ``flag``: trajectories flagged as bad, and flags carried into another store.
- ``keep_sensors``: sensors that no recording brought stay through merges and replacements.

What is copied is checked against its digests first: damage is refused, never carried on.
"""
