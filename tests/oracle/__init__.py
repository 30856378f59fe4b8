"""Slow, independent solutions that the fast kernels are held against."""
