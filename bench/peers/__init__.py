"""Other programs on the same equations, against the march."""
