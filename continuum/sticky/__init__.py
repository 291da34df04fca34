"""Is my surface sticky?  Materials, what each theory says of a rough contact, its record, and the verdict."""
