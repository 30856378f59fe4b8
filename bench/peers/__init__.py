"""Other programs on the same wheels."""
