"""The scene file: its keys, its rules, its estimates; from TOML to a checked, frozen Scene."""
