"""The right-hand side y' = f(t, y): bodies, wheels, drives, and the forces that the floor gives."""
