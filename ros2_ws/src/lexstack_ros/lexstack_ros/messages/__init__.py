"""Messages: to and from the library's values, and the quality of service of their topics."""
