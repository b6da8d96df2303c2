"""The configuration: one schema, from YAML files to frozen dataclasses."""
