"""Scoring: how far apart are the pictures of the sensors of a store?

Read in this order:

- ``sensor_sets``: frames of a store by sensor; recorded, simulated and synthetic ones are kept apart.
- ``chosen_scores``: the scores that a person names.
- ``sensor_pairs``: scores of each set against each other one.
- ``background_targets``: scores against a sensor of which only the picture without contact is known.
- ``kept_touches``: how much of the touches synthetic pictures keep that were made of them.
- ``embedding_picture``: a picture of the latent vectors of all sets.

This room reads stores and calls metrics. It trains nothing: who encodes pictures hands in the function.
"""
