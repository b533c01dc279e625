"""Cases of a proof: what is hidden in which world, drawn by a seed, and how much of it can be seen.

`configuration` says which generator records which plan, with which errors and noise.
`world_case` is a case; its document is the label that is sealed.
`kinds` lists the kinds of cases, and says from when on an effect can be seen or is concealed.
`strengths` draws the numbers of an effect; `draw` draws cases until they are of the kind that is asked for.
`drawn_world` is a world before it is decided what it hides.
`oracle` decides how much of an effect can be seen, and whether a calibration conceals it.
`truth` has the names of hidden effects in the catalogue.
"""
