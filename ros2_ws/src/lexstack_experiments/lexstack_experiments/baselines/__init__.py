"""What the experiments compare with, and nobody else needs."""
