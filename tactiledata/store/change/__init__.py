"""A store that is merged, corrected or given a sensor."""
