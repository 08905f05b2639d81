"""What the add-on tells its user and then stops."""


class Problem(Exception):
    """One sentence or two: what is wrong, and what to do."""
