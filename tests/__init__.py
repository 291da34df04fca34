"""Tests, in four folders; each of these has the rooms of both packages.

``physics`` tests the laws of the field, ``files`` what is read and stored, ``doors`` what a person calls and is told,
``repository`` pages, names and the structure.
"""
