"""What is looked at: plots, and the machine moving in 3-D on a page."""
