"""Products, factors and part sums that terms have in common, each computed once.

What saves most multiplications comes first. Constants count as factors.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable
from itertools import combinations
from typing import Generic, TypeVar

from .read import Factors, Sums

MOST = 8  # uses of what is shared first; then come fewer uses, down to 2
LONGEST_SUM = 40  # [terms] part sums of longer sums are not shared

Term = tuple[int, Factors]  # sign and factors
Terms = list[Term]
# factors of two terms, and the product of their signs
Pair = tuple[Factors, Factors, int]
Key = TypeVar("Key")
Place = TypeVar("Place")


class SharedSums:
    """Sums of products with shared parts.

    Attributes:
        terms: terms of each atom that is a sum or a product.
        constants: value of each atom that is a constant; these atoms are negative.
    """

    def __init__(self, sums: Sums) -> None:
        self.constants: dict[int, float] = {}
        self._atoms: dict[str, int] = {}
        self._last = len(sums.trace.graph.nodes)
        self._factored: dict[tuple[Term, ...], int] = {}
        self.terms: dict[int, Terms] = {}
        for atom, terms in sums.sums.items():
            self.terms[atom] = [self._term(factors, k) for factors, k in terms.items()]

    def share_products(self, least: int) -> None:
        """Compute each product of two factors once, if it occurs in at least `least` terms."""
        uses: _Uses[tuple[int, int], tuple[int, int]] = _Uses(least)
        for atom, terms in self.terms.items():
            for k, (_, factors) in enumerate(terms):
                uses.add((atom, k), _pairs(factors))
        for pair in uses.most_used():
            product = self._new()
            for atom, k in sorted(uses.places(pair)):
                sign, factors = self.terms[atom][k]
                uses.remove((atom, k), _pairs(factors))
                others = _without(_without(factors, pair[0]), pair[1])
                factors = _with(others, product)
                self.terms[atom][k] = sign, factors
                uses.add((atom, k), _pairs(factors))
            self.terms[product] = [(1, pair)]

    def share_factors(self, least: int) -> None:
        """Take out each factor that at least `least` terms of a sum have in common."""
        waiting = [atom for atom, terms in self.terms.items() if len(terms) > 1]
        while waiting:
            atom = waiting.pop()
            factor = self._best_factor(atom, least)
            while factor is not None:
                with_factor, terms = _divided(self.terms[atom], factor)
                sign, key = _signed(with_factor)
                if key not in self._factored:
                    inner = self._new()
                    self._factored[key] = inner
                    self.terms[inner] = list(key)
                    waiting.append(inner)
                product = _with((factor,), self._factored[key])
                terms.append((sign, product))
                self.terms[atom] = terms
                factor = self._best_factor(atom, least)

    def share_part_sums(self) -> None:
        """Compute each sum of two terms once, if it occurs in two or more sums."""
        uses: _Uses[Pair, int] = _Uses(2)
        for atom, terms in self.terms.items():
            if len(terms) <= LONGEST_SUM:
                uses.add(atom, _part_sums(terms))
        for pair in uses.most_used():
            first, second, relative = pair
            part = self._new()
            for atom in sorted(uses.places(pair)):
                terms = self.terms[atom]
                uses.remove(atom, _part_sums(terms))
                sign = next(sign for sign, factors in terms if factors == first)
                terms.remove((sign, first))
                terms.remove((sign * relative, second))
                terms.append((sign, (part,)))
                uses.add(atom, _part_sums(terms))
            self.terms[part] = [(1, first), (relative, second)]

    def _term(self, factors: Factors, coefficient: float) -> Term:
        """A product with its coefficient, which becomes an atom if it is not 1 or -1."""
        sign = 1 if coefficient > 0.0 else -1
        size = abs(coefficient)
        if size == 1.0:
            return sign, factors
        digits = f"{size:.14e}"  # constants that differ by rounding are one
        if digits not in self._atoms:
            self._atoms[digits] = -1 - len(self._atoms)
            self.constants[self._atoms[digits]] = size
        return sign, _with(factors, self._atoms[digits])

    def _new(self) -> int:
        """The number of a new atom."""
        self._last += 1
        return self._last

    def _best_factor(self, atom: int, least: int) -> int | None:
        """The factor of a sum that saves most multiplications, if `least` terms have it."""
        terms = self.terms[atom]
        counts: Counter[int] = Counter()
        for _, factors in terms:
            counts.update(set(factors))
        best, most = None, least - 1.5  # less than a factor of `least` terms saves
        for factor in sorted(counts, reverse=True):
            if counts[factor] < 2:
                continue
            saved: float = counts[factor] - 1
            inner, _ = _divided(terms, factor)
            _, key = _signed(inner)
            if key in self._factored:  # the sum is there, and need not be computed
                additions = 0.5 * saved
                saved += additions + sum(max(len(factors) - 1, 0) for _, factors in inner)
            if saved > most:
                best, most = factor, saved
        return best


def share(sums: Sums) -> SharedSums:
    """Share products, factors and part sums of sums; what saves most comes first."""
    shared = SharedSums(sums)
    for least in range(MOST, 1, -1):
        shared.share_products(least)
        shared.share_factors(least)
    shared.share_part_sums()
    return shared


class _Uses(Generic[Key, Place]):
    """Places where keys are used, and the keys by number of places."""

    def __init__(self, least: int) -> None:
        self._least = least
        self._places: dict[Key, dict[Place, None]] = defaultdict(dict)
        self._heap: list[tuple[int, Key]] = []

    def add(self, place: Place, keys: Iterable[Key]) -> None:
        """Note that keys are used at a place."""
        for key in keys:
            self._places[key][place] = None
            self._push(key)

    def remove(self, place: Place, keys: Iterable[Key]) -> None:
        """Note that keys are not used at a place."""
        for key in keys:
            self._places[key].pop(place, None)

    def places(self, key: Key) -> list[Place]:
        """The places of a key."""
        return list(self._places[key])

    def most_used(self) -> Iterable[Key]:
        """The most used keys, down to the least number of uses; uses may change in between."""
        while self._heap:
            count, key = heapq.heappop(self._heap)
            if len(self._places[key]) != -count:
                continue  # its uses changed; if they grew, a later entry has them
            yield key

    def _push(self, key: Key) -> None:
        """Enter a key with its number of uses, if that is large enough."""
        count = len(self._places[key])
        if count >= self._least:
            heapq.heappush(self._heap, (-count, key))


def _pairs(factors: Factors) -> list[tuple[int, int]]:
    """All pairs of two factors, each once."""
    return list(dict.fromkeys(combinations(factors, 2)))


def _part_sums(terms: Terms) -> list[Pair]:
    """All pairs of two terms, each once."""
    pairs: dict[Pair, None] = {}
    ordered = sorted(terms, key=_factors)
    for (sign, factors), (other_sign, others) in combinations(ordered, 2):
        pairs[factors, others, sign * other_sign] = None
    return list(pairs)


def _factors(term: Term) -> Factors:
    """The factors of a term, which order terms."""
    return term[1]


def _with(factors: Factors, atom: int) -> Factors:
    """Factors with one more, in order."""
    return tuple(sorted((*factors, atom)))


def _without(factors: Factors, atom: int) -> Factors:
    """Factors with one less."""
    place = factors.index(atom)
    return factors[:place] + factors[place + 1 :]


def _divided(terms: Terms, factor: int) -> tuple[Terms, Terms]:
    """The terms with a factor, divided by it, and the others."""
    divided: Terms = []
    others: Terms = []
    for sign, factors in terms:
        if factor in factors:
            divided.append((sign, _without(factors, factor)))
        else:
            others.append((sign, factors))
    return divided, others


def _signed(terms: Terms) -> tuple[int, tuple[Term, ...]]:
    """A sum as a sign times ordered terms, the first of them positive: so -x shares x."""
    ordered = sorted(terms, key=_factors)
    first = ordered[0][0]
    return first, tuple((sign * first, factors) for sign, factors in ordered)
