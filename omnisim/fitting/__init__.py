"""Machines fitted to measured logs: a scene's keys estimated, with what the logs can tell of them."""
