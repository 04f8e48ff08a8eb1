"""What every engine carries: which logs are to be traced, and the trace of one.

The answer to `LOGS/arm03_2024-05.csv` is `ANSWERS/arm03_2024-05.json`, what `dynamics trace --json`
prints; or `ANSWERS/arm03_2024-05.error`, why the log cannot be used. An answer is there whole or not
at all. As with `make`, one that is older than its log or the model is made again; what is newer is
done, whoever did it.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import dynamics

ENDINGS = (".json", ".error")


class Work:
    """What the command line names, and what of it is left to do.

    Attributes:
        model: the model's file.
        answers: the folder of the answers.
        workers: how many processes trace at once.
        left: the logs that have no answer, or an old one.
    """

    def __init__(self, engine: str) -> None:
        """Reads the command line of a program that has `engine` carry the work."""
        parser = argparse.ArgumentParser(description=f"Traces a fleet's logs with {engine}.")
        parser.add_argument("model", type=Path)
        parser.add_argument("logs", type=Path, help="the folder of the logs, MACHINE_DATE.csv")
        parser.add_argument("answers", type=Path, help="the folder of the answers")
        parser.add_argument("--workers", type=int, default=os.cpu_count())
        given = parser.parse_args()
        # A model with a fault is no fault of the logs: it ends the program here.
        dynamics.Model.load(given.model)
        given.answers.mkdir(parents=True, exist_ok=True)
        self.model: Path = given.model
        self.answers: Path = given.answers
        self.workers: int = given.workers
        logs = sorted(given.logs.glob("*.csv"))
        self.left = [log for log in logs if not is_done(self.model, log, self.answers)]
        print(f"{len(logs)} logs, {len(logs) - len(self.left)} done before", flush=True)


def is_done(model: Path, log: Path, answers: Path) -> bool:
    """Whether a log has an answer that is newer than the log and the model."""
    newest = max(model.stat().st_mtime_ns, log.stat().st_mtime_ns)
    there = [answers / f"{log.stem}{ending}" for ending in ENDINGS]
    return any(answer.exists() and answer.stat().st_mtime_ns >= newest for answer in there)


def answer(model: Path, log: Path, answers: Path) -> str:
    """Traces one log and writes the answer.

    Returns:
        What became of it, in a line.
    """
    try:
        found = dynamics.trace(model, log)
    except dynamics.Error as error:
        write(answers / f"{log.stem}.error", f"{error}\n")
        return f"{log.stem}: cannot be used"
    write(answers / f"{log.stem}.json", f"{found.json}\n")
    return f"{log.stem}: {found!r}"


def write(path: Path, text: str) -> None:
    """Writes a file whole or not at all, in the place of an older answer of either kind."""
    part = path.with_name(f".{path.name}.{os.getpid()}")
    part.write_text(text)
    part.replace(path)
    for ending in ENDINGS:
        if ending != path.suffix:
            path.with_suffix(ending).unlink(missing_ok=True)
