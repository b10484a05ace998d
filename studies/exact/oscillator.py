#!/usr/bin/env python3
"""Two particles swing along a line by TR171's law: the period by quadrature, in 40 digits.

    oscillator.py > data/oscillator.csv

With r = (a + b)/2 - (b - a)/2 cos(phi) between the turns a and b, dr/v has no singularity and is
even and periodic in phi, so that the midpoint rule converges faster than any power. The scene ends
at the double next to ten periods: the state there is that of a turn, a little later.
"""
from decimal import Decimal as D, getcontext

getcontext().prec = 50
INNER, MU, END = D("1.0625"), D(2) / D(3), D(24.22484785420712)


def potential(r):
    return r ** -9 - r ** -6


def force(r):
    return 9 * r ** -10 - 6 * r ** -7


def bisect(low, high, is_low):
    for _ in range(170):
        middle = (low + high) / 2
        if is_low(middle):
            low = middle
        else:
            high = middle
    return low


def cosine_and_sine(n, count):
    """Of the midpoints (k + 1/2) pi / count, by rotation from the first, which comes from a series."""
    pi = bisect(D(3), D(4), lambda x: series(x, 1) > 0)
    step = pi / (2 * count)
    c, s = series(step, 0), series(step, 1)
    c2, s2 = c * c - s * s, 2 * s * c
    for _ in range(n):
        yield c, s
        c, s = c * c2 - s * s2, s * c2 + c * s2


def series(x, odd):
    term, total, k = x if odd else D(1), D(0), odd
    while abs(term) > D(10) ** -52:
        total += term
        term *= -x * x / ((k + 1) * (k + 2))
        k += 2
    return total


def half_period(count):
    a = INNER
    b = bisect(D("1.15"), D(10), lambda r: potential(r) < potential(a))
    total = D(0)
    for c, s in cosine_and_sine(count, count):
        r = (a + b) / 2 - (b - a) / 2 * c
        total += (b - a) / 2 * s / (2 * (potential(a) - potential(r)) / MU).sqrt()
    pi = bisect(D(3), D(4), lambda x: series(x, 1) > 0)
    return total * pi / count


period = 2 * half_period(400)
late = END - 10 * period
pull = force(INNER) / MU
distance = INNER + pull * late * late / 2
speed = pull * late
print("# Written by oscillator.py: period", str(period)[:36])
print("particle,x,y,vx,vy")
for number, share in ((1, -D(2) / 3), (2, D(1) / 3)):
    place = (D(0) if number == 1 else INNER) + share * (distance - INNER)
    print(f"{number},{place:.30f},0,{share * speed:.6e},0")
