"""Markdown, as far as the results need it."""


def table(head, rows, words=1):
    """The first `words` columns are aligned left, the others right."""
    for row in rows:
        if len(row) != len(head):
            raise ValueError(f"a row of {len(row)} cells under a head of {len(head)}: {row}")
    marks = ["---"] * words + ["---:"] * (len(head) - words)
    return ["| " + " | ".join(map(str, cells)) + " |" for cells in [head, marks, *rows]]


def number(value):
    """Three digits or so; nothing where there is nothing."""
    if value is None:
        return ""
    decimals = next((n for n, limit in ((0, 100), (1, 10), (2, 0.1)) if abs(value) >= limit), 3)
    return f"{value:.{decimals}f}" if value else "0"


def spread(summary):
    """Median and p95."""
    return "" if summary is None else f"{number(summary.median)} ({number(summary.p95)})"


def ratio(value):
    return "" if value is None else f"{value:.3f}"


def count(value):
    """1000 as 1k, 1000000 as 1M."""
    for size, unit in ((1_000_000, "M"), (1_000, "k")):
        if value >= size and value * 10 % size == 0:
            return f"{value / size:g}{unit}"
    return str(value)
