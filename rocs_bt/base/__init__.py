"""Small things below all rooms: errors, units, geometry, clocks, files, TOML with positions, Python content."""
