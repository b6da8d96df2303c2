"""What a bag says of a run: columns of its messages, in time."""
