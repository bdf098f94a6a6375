"""Random faults in the product, and whether the tests of their own layer notice them.

python tools/mutants.py COUNT [--seed 0] [--only PART] [--limit S] [--work FOLDER]

Which test runs which line is recorded once for each place of tests. A mutant meets the tests that
run its line, the quickest first, then the others of their files; the first that fails kills it.
One that takes far too long is killed too. A constant counts as the lines that use it.
Works in copies of the checkout below --work, where records and results are kept: a run that was
ended goes on where it was. Another state of the checkout takes another folder. Each line of the
report is one mutant: killed, alive, or not run by any test, with its change. Read those that live:
they are equal to the original, or a law is missing.
"""

from __future__ import annotations

import argparse
import json
import math
import random
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import get_context
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import Any

from mutation import process
from mutation.bench import ROOT, Bench, record_of
from mutation.layers import places_of
from mutation.sites import Site, sites

BENCHES: list[Bench] = []  # the one of a worker


def take_bench(work: Path, limit: float, numbers: SimpleQueue[int]) -> None:
    """Make a worker's bench."""
    BENCHES.append(Bench(work, limit, numbers.get()))


def make_record(place: str) -> None:
    """Record a place of tests on a worker's bench."""
    BENCHES[0].record(place)


def outcome(site: Site) -> dict[str, Any]:
    """Try a mutant on a worker's bench."""
    return BENCHES[0].outcome(site)


class Plan:
    """What is still to be done; a mutant waits for the records of its tests.

    Attributes:
        waiting: mutants.
    """

    def __init__(self, waiting: list[Site], work: Path) -> None:
        self.waiting = waiting
        self._work = work
        self._begun: set[str] = set()

    def next_task(self) -> tuple[Callable[[Any], Any], Any] | None:
        """A function and its argument; None where everything waits or nothing is left."""
        for site in self.waiting:
            if not self._missing(site):
                self.waiting.remove(site)
                return outcome, site
        for site in self.waiting:
            for place in self._missing(site):
                if place not in self._begun:
                    self._begun.add(place)
                    return make_record, place
        return None

    def _missing(self, site: Site) -> list[str]:
        places = places_of(site.module)
        return [place for place in places if not record_of(self._work, place).exists()]


def outcomes(plan: Plan, pool: ProcessPoolExecutor, workers: int) -> Iterator[dict[str, Any]]:
    """Results of mutants as they come."""
    running: set[Future[Any]] = set()
    while True:
        while len(running) < workers and (task := plan.next_task()):
            running.add(pool.submit(*task))
        if not running:
            return
        done, running = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            if result := future.result():
                yield result


def results(path: Path) -> dict[Site, dict[str, Any]]:
    """What is in the file of results."""
    if not path.exists():
        return {}
    lines = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return {Site(line["module"], line["number"]): line for line in lines}


def try_all(
    chosen: Sequence[Site], work: Path, workers: int, limit: float
) -> dict[Site, dict[str, Any]]:
    """Try those that have no result yet, print them, and give the results of all."""
    work.mkdir(parents=True, exist_ok=True)
    path = work / "results.jsonl"
    done = results(path)
    process.import_libraries()
    context = get_context("fork")
    numbers = context.SimpleQueue()
    for number in range(workers):
        numbers.put(number)
    plan = Plan([site for site in chosen if site not in done], work)
    with ProcessPoolExecutor(workers, context, take_bench, (work, limit, numbers)) as pool:
        for result in outcomes(plan, pool, workers):
            with path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(result) + "\n")
            text = "{state} {seconds} s {module} {change}   {killer}".format(**result)
            print(len(chosen) - len(plan.waiting), text.rstrip(), flush=True)
    return results(path)


def main() -> None:
    """Try so many mutants and print each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="of them those with this in their path")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--limit", type=float, default=math.inf, help="of tests of a mutant [s]")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    every = sites(ROOT)
    chosen = random.Random(arguments.seed).sample(every, min(arguments.count, len(every)))  # noqa: S311
    chosen = [site for site in chosen if arguments.only in site.module]
    done = try_all(chosen, arguments.work.resolve(), arguments.workers, arguments.limit)
    alive = sum(done[site]["state"] != "killed" for site in chosen)
    print(f"{alive} of {len(chosen)} live")


if __name__ == "__main__":
    main()
