"""What every node of ours does: starts, is ready, reports, ends."""
