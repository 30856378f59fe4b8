"""Running scenes: at once, step by step, by the error that is asked for, against the clock."""
