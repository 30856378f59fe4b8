"""Machines as native code: compiled kernels in libraries that need no Python."""
