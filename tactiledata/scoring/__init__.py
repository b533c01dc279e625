"""Metrics over stores: how far apart the pictures of sensors are.

- ``sensor_sets``: which pictures of a store stand for a sensor, and how many of them.
- ``chosen_scores``: the scores that a user names.
- ``sensor_pairs``: scores of all pairs of sensors; start here. ``background_targets``: a target that is known by its
  picture without contact alone is scored outside the contact.
- ``embedding_picture``: vectors of touches on a plane, to look at.

Metrics themselves are in ``metrics``: they know arrays, no stores.
"""
