"""Machines free in space: the chassis a rigid body with six degrees of freedom, on rubber, springs and real ground."""
