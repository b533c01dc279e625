"""Effects planted into a copy of a user's own store: a proof on real recordings, with a sealed label.

`effects` lists what can be planted, each as a change of the force sensor's readings or of what a log states.
`planting` copies a store with the change; everything derived from the readings is derived anew.
`label` seals what was planted, outside of the copy, and scores a diagnosis against it.

The real recordings stay as they are. What they lacked before, they lack in the copy, too:
diagnose both, and compare.
"""
