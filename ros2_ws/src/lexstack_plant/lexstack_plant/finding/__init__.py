"""A plant file from what runs: controllers, joints and topics that are there now."""
