"""Recorded worlds: a rig that plays a scenario with known truth and writes ordinary logs of it.

The rig has its own contact and its own optics and shares no model code with the toolkit that reads its logs; that is
what makes a test on them a test.
"""
