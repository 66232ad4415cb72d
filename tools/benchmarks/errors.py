"""How a benchmark ends early: one sentence on stderr, and an exit code."""


class BenchError(Exception):
    """Something failed."""
    code = 1


class UsageError(BenchError):
    """The options ask for something impossible."""
    code = 2
