"""What a tool makes of a machine's log, and how many lines its user writes."""

import inspect
import time
from contextlib import contextmanager
from dataclasses import dataclass

BEGIN, END = "# a user writes this", "# up to here"


@dataclass
class Answer:
    """One tool's answer about one machine."""

    tool: str
    error: float
    """Of its predictions of the held-out log (scoring.py)."""
    seconds: float
    """Processor time."""
    says: str
    """What it says that the machine has."""


def lines(module):
    """Lines of a module between the two marks, less blank ones and comments."""
    count, inside = 0, False
    for line in inspect.getsource(module).splitlines():
        text = line.strip()
        if text in (BEGIN, END):
            inside = text == BEGIN
        elif inside and text and not text.startswith("#"):
            count += 1
    return count


@contextmanager
def clock():
    """A list whose entry becomes the processor seconds of all threads in between."""
    spent, start = [0.0], time.process_time()
    yield spent
    spent[0] = time.process_time() - start


def number(value):
    """Three digits."""
    return f"{value:.3g}"
