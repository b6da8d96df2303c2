"""What tasks ask for, as compiled functions."""
