"""The viewer: what happened in a touch, all streams of it on one time line (docs/view.md).

- ``options``: what is shown, and how much of it. ``chosen``: which trajectories and which of their frames these are.
- ``recording``: the entry; the trajectories of a store become one file that rerun's viewer opens.
- ``touch``: what a store knows of one trajectory. ``touch_log``: the rerun recording that it becomes, with its times.
- ``pictures``, ``gel``, ``curves``: what is seen, how the gel is deformed, and what was measured and simulated.
- ``about``: what a person should know of the trajectory, in words. ``panes``: where everything is on the screen.
- ``rerun_package``: the optional package. ``serve``: the viewer, as a program or in a browser.

Measured values are dots and simulated ones are lines, always.
"""
