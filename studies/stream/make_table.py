#!/usr/bin/env python3
"""Writes the initial state of TR171's stream as CSV: make_table.py [V] > data/stream_vV.csv

Positions (section 3): rows of 11, 12 and 11 particles. P13 to P22 are the centres of regular
hexagons of radius 1.5^(1/3), the other particles their vertices: the rows lie radius * sqrt(3)/2
apart and are shifted by half a radius. P12 is at the origin and the first row above it.

Velocities: (V + e1, e2) with one set of random numbers for every V, scaled so that the largest |e|
is 1 % of V exactly. The report does not print its set; this one comes from a seeded generator.
"""
import random
import sys

SEED = 1973
RADIUS = 1.5 ** (1 / 3)
HEIGHT = RADIUS * 3**0.5 / 2
ROWS = ((11, 0.5, HEIGHT), (12, 0.0, 0.0), (11, 0.5, -HEIGHT))


def positions():
    return [((i + shift) * RADIUS, y) for count, shift, y in ROWS for i in range(count)]


def perturbations(count):
    generator = random.Random(SEED)
    raw = [(generator.uniform(-1, 1), generator.uniform(-1, 1)) for _ in range(count)]
    largest = max(abs(value) for pair in raw for value in pair)
    return [tuple(round(value / largest, 6) for value in pair) for pair in raw]


def main():
    speed = float(sys.argv[1]) if len(sys.argv) > 1 else 50.0
    places = positions()
    print(f"# TR171 (Greenspan, 1973), section 3: the stream of Figures 3.1 and 3.2, V = {speed:g}.")
    print(f"# Made by make_table.py {speed:g} (seed {SEED}; the report does not print its numbers).")
    print("x,y,vx,vy")
    for (x, y), (e1, e2) in zip(places, perturbations(len(places))):
        vx, vy = round(speed + e1 * speed / 100, 9), round(e2 * speed / 100, 9)
        print(f"{x!r},{y!r},{vx!r},{vy!r}")


if __name__ == "__main__":
    main()
