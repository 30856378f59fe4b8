"""Other programs on the same wheels and machines."""
