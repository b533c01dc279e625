"""Answers of a proof: the diagnosis of one case, from its readings alone.

`case_readings` has the readings of a case.
`named` is the diagnosis: it knows the plan and the readings.
`failed` is the answer where an error ended that diagnosis.
`tasks` has the tasks that workers run: solve a touch, draw a case, diagnose a case.

A task leaves whole files behind, whenever it is killed,
so that a run goes on where it ended.
"""
