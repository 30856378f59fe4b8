"""Wheels and machines for workshops and other simulators: profiles, meshes, drawings, MJCF, URDF."""
