"""Reports: how results become a page or a picture that a person wants to read.

`page` renders sentences, tables and pictures as one HTML file. `marks` says how measured and simulated values are drawn
in all pictures, and `panels` cuts a figure into the panels of a page, with a legend; `drawing` draws names in any
script. `plots` draws recorded touches; `replay_plots`, `calibration_plots`, `diagnosis_plots` and `naming_plots` draw
what the part of the toolkit of that name found. `finding_words` explains the codes of findings.

Rendering only: the room computes no results, reads no store and decides no wording. matplotlib and jinja2 are imported
where something is drawn, so that the package works without them.
"""
