"""Prediction of stickiness: materials, theories of rough contact, their record, and the verdict."""
