"""Numbers from a gap: areas and loads, outline and patches, profiles, and what a path of them says about adhesion.

Everything here is counted or averaged on the points of one state, or on the points of one path; nothing is solved.
"""
