"""Pictures of one sensor in the style of another."""
