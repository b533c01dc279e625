"""Which known effect is missing: screening, refits, evidence, decision."""
