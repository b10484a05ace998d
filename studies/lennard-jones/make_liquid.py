#!/usr/bin/env python3
"""Writes a Lennard-Jones liquid as CSV: make_liquid.py > data/liquid_500.csv

500 particles in reduced units (mass, epsilon, sigma = 1) in a periodic cube of density 0.8442: a
face-centred cubic lattice of 5^3 cells with normally distributed velocities of temperature 2.4
melts in 600 steps of 0.005 of the velocity-Verlet method (potential cut at 2.5); in the next 1000
its velocities are scaled to temperature 0.722 every 20 steps, then it is left alone for 400, and
scaled once more. The random numbers have a fixed seed and the arithmetic is Python's own, a fixed
order of additions included: the same numbers on every machine. It takes about half a minute.
"""
import random

SEED = 1967
CELLS, DENSITY, CUTOFF, SKIN = 5, 0.8442, 2.5, 0.4
HOT, TEMPERATURE = 2.4, 0.722
STEP, STEPS, EVERY = 0.005, 2000, 20
SCALED = range(600, 1600)

COUNT = 4 * CELLS**3
SIDE = round((COUNT / DENSITY) ** (1 / 3), 6)


def lattice():
    base = ((0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5))
    edge = SIDE / CELLS
    cells = range(CELLS)
    return [[edge * (k + b + 0.25) for k, b in zip((i, j, l), offset)]
            for i in cells for j in cells for l in cells for offset in base]


def scale(velocities, temperature):
    """No momentum, and (3 N - 3) temperature = sum of v^2."""
    for c in range(3):
        mean = sum(v[c] for v in velocities) / COUNT
        for v in velocities:
            v[c] -= mean
    square = sum(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] for v in velocities)
    factor = ((3 * COUNT - 3) * temperature / square) ** 0.5
    for v in velocities:
        for c in range(3):
            v[c] *= factor


def nearest(d):
    return d - SIDE * round(d / SIDE)


def neighbours(positions):
    reach = (CUTOFF + SKIN) ** 2
    rows = []
    for i, (x, y, z) in enumerate(positions):
        rows.append([j for j in range(i + 1, COUNT)
                     if nearest(x - positions[j][0]) ** 2 + nearest(y - positions[j][1]) ** 2
                     + nearest(z - positions[j][2]) ** 2 <= reach])
    return rows


def forces(positions, rows):
    force = [[0.0, 0.0, 0.0] for _ in positions]
    half, square = SIDE / 2, CUTOFF * CUTOFF
    for i, row in enumerate(rows):
        xi, yi, zi = positions[i]
        fx = fy = fz = 0.0
        for j in row:
            xj, yj, zj = positions[j]
            dx, dy, dz = xi - xj, yi - yj, zi - zj
            if not -half <= dx <= half:
                dx = nearest(dx)
            if not -half <= dy <= half:
                dy = nearest(dy)
            if not -half <= dz <= half:
                dz = nearest(dz)
            s = dx * dx + dy * dy + dz * dz
            if s > square:
                continue
            inverse = 1 / s
            six = inverse * inverse * inverse
            f = (48 * six - 24) * six * inverse
            fx += f * dx
            fy += f * dy
            fz += f * dz
            other = force[j]
            other[0] -= f * dx
            other[1] -= f * dy
            other[2] -= f * dz
        own = force[i]
        own[0] += fx
        own[1] += fy
        own[2] += fz
    return force


def moved(positions, origin):
    limit = (SKIN / 2) ** 2
    return any(sum((a - b) * (a - b) for a, b in zip(p, o)) > limit
               for p, o in zip(positions, origin))


def melt(positions, velocities):
    origin = [list(p) for p in positions]
    rows = neighbours(positions)
    force = forces(positions, rows)
    for step in range(1, STEPS + 1):
        for p, v, f in zip(positions, velocities, force):
            for c in range(3):
                v[c] += STEP / 2 * f[c]
                p[c] += STEP * v[c]
        if moved(positions, origin):
            origin = [list(p) for p in positions]
            rows = neighbours(positions)
        force = forces(positions, rows)
        for v, f in zip(velocities, force):
            for c in range(3):
                v[c] += STEP / 2 * f[c]
        if step in SCALED and step % EVERY == 0:
            scale(velocities, TEMPERATURE)


def main():
    generator = random.Random(SEED)
    positions = lattice()
    velocities = [[generator.gauss(0, 1) for _ in range(3)] for _ in positions]
    scale(velocities, HOT)
    melt(positions, velocities)
    scale(velocities, TEMPERATURE)
    print(f"# Lennard-Jones liquid: {COUNT} particles, reduced units, density {DENSITY}, temperature")
    print(f"# {TEMPERATURE}, in a periodic cube of side {SIDE}. Made by make_liquid.py (seed {SEED}).")
    print("x,y,z,vx,vy,vz")
    for p, v in zip(positions, velocities):
        print(",".join(repr(round(q % SIDE, 9)) for q in p) + ","
              + ",".join(repr(round(q, 9)) for q in v))


if __name__ == "__main__":
    main()
