"""Running systems under test: faults, loads, several hosts on one machine."""
