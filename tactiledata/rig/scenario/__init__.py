"""Scenarios: what a recorded world consists of.

`scenario` reads and checks a scenario file (``schemas/scenario.json``) and gives frozen records with defaults.
`generate` draws touches at random where the file asks for that.
`worlds` finds the scenarios of the toolkit by name.

The room plays nothing: it imports the plans of touches and the table of hidden effects, never contact or logs.
"""
