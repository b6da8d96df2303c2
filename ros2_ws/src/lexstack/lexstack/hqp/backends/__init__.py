"""QP libraries behind the hierarchy: each names the active set of one level after another."""
