"""Other ways to compute the same motion."""
