"""YAML files as options of the library: robots, stacks, scenarios, plants, parameters."""
