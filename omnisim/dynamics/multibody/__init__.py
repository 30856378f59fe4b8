"""The multibody formulation: every body, every joint, every multiplier."""
