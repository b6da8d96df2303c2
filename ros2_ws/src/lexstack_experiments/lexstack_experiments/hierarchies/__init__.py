"""Hierarchical problems to measure solvers with: random and recorded, a certificate, peers."""
