"""One call of `hybrid-dynamics bag` that ends as expected."""

from __future__ import annotations

from tests.cli.calling import Answer, call


def run(*words: object, code: int = 0) -> Answer:
    """Call `bag` with these words; it has to end with the code."""
    answer = call("bag", *map(str, words))
    assert answer.exit_code == code, answer.output
    return answer


def printed(*words: object, code: int = 0) -> str:
    """What such a call prints on stdout."""
    return run(*words, code=code).stdout


def output(*words: object, code: int = 0) -> str:
    """What such a call prints, errors last."""
    return run(*words, code=code).output
