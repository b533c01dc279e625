"""Banked contacts: how contacts of the layer solver, solved once, serve many recordings of the same touches.

`bank` gives the contact of a touch by interpolating between solutions.
`solution` is one solution: its key and its file.

Of the rig, the room imports `contact`, `hidden` (springs, sliders and the limit of friction), `layer`, `motion` and
`scenario`. It draws no pictures: a banked contact has forces only.
"""
