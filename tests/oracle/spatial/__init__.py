"""Slow, independent solution of machines free in space: every body free, every joint a multiplier."""
