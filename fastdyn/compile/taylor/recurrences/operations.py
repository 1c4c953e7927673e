"""The recurrences for Taylor coefficients that make up a function.

With c[k] the coefficient of order k, and sums over 0 < j < k::

    Sum       c = C + sum(f a) + sum(f a b)    c[k] = sum(f a[k]) + sum(f (a[k] b0 + a0 b[k])) + ...
                                               with f a[j] b[k-j] summed
    Quotient  c = f a / b                      c[k] = (f a[k] - c0 b[k] - sum(b[j] c[k-j])) / b0
    Power     c = f a^e                        c[k] = (e c0 k a[k] + sum((e j - (k-j)) a[j] c[k-j]))
                                               / (k a0)
    Root      c = sqrt(a)                      c[k] = (a[k] - sum(c[j] c[k-j])) / (2 c0)
    Integral  c = sum(integral of f g da)      c[k] = sum(f (a[k] g0 + sum(j a[j] g[k-j]) / k))
    Choice    c = a if a condition holds, else b; the condition is evaluated at order 0

f and C are invariants: nodes that depend on neither the state nor the time.
"""  # fmt: skip

from typing import Any, NamedTuple


class Sum(NamedTuple):
    """A sum; `terms` has pairs (f, a), `products` has triples (f, a, b)."""

    node: Any
    constant: Any
    terms: list
    products: list


class Quotient(NamedTuple):
    """A quotient; `a` is None for a = 1."""

    node: Any
    factor: Any
    b: Any
    a: Any


class Power(NamedTuple):
    """c = f a^e"""

    node: Any
    factor: Any
    a: Any
    exponent: float


class Root(NamedTuple):
    """c = sqrt(a)"""

    node: Any
    a: Any


class Integral(NamedTuple):
    """A sum of integrals of f g da; `parts` has triples (f, a, g)."""

    node: Any
    name: str
    arguments: list
    parts: list


class Choice(NamedTuple):
    """c = a if the condition holds, else b"""

    node: Any
    condition: Any
    a: Any
    b: Any
