"""The front door: contacts, runs and predictions as a person calls them.  What a command does, one of these does.

Everything here is a short way to the rooms behind it, and shows itself as a small table in a notebook.
"""
