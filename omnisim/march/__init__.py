"""Marching in time: steps, events, modes of friction and contact, and what is watched on the way."""
