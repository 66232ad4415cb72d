"""What is said about a series of measurements."""
import dataclasses


@dataclasses.dataclass(frozen=True)
class Summary:
    """`p95` is by nearest rank: the smallest value with at least 95 % of the series at or below it, so that it is
    always a value that was measured; of fewer than 20 values it is the largest."""
    median: float
    p95: float
    minimum: float
    count: int

    def as_json(self):
        return dataclasses.asdict(self)


def summarise(values):
    ordered = sorted(values)
    if not ordered:
        raise ValueError("nothing was measured")
    count = len(ordered)
    middle = count // 2
    median = ordered[middle] if count % 2 else (ordered[middle - 1] + ordered[middle]) / 2
    return Summary(median, ordered[(95 * count + 99) // 100 - 1], ordered[0], count)


def rounds(items, repeats):
    """The items once in each round, every second round backwards: what drifts evenly then harms all alike.
    `repeats(item)` says in how many rounds an item takes part."""
    for number in range(max(map(repeats, items), default=0)):
        order = items if number % 2 == 0 else items[::-1]
        yield from (item for item in order if number < repeats(item))
