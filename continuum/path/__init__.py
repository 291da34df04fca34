"""Equilibria on branches: one state at a given control, a given area by a search, and paths with their jumps.

Each state starts from the one before, never from one that failed, and carries its status.
"""
