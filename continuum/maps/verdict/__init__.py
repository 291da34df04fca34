"""Prediction of stickiness: materials, the threshold of a map, theories for comparison, and the verdict."""
