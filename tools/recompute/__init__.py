"""The stages of tools/recompute_dump.py."""
