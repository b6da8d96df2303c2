"""Messages on their way in: in order, each tick once, and how late."""
