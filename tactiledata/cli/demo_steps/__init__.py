"""Steps of `tactiledata demo` that simulate, diagnose and transfer its touches; `cli/demo.py` calls them in turn.

- ``gel``: a calibration on touches of balls, and a replay with the calibrated material.
- ``diagnosis``: which physics the simulation of these touches lacks.
- ``transfer``: touches of one sensor in the style of another, with their scores.

Each step takes the demo's folder and a function that prints a line; a step that needs what is not installed says so and
is left out.
"""
