"""Generator of the built-in courtyard scene (standard library only, deterministic)."""
