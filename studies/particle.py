#!/usr/bin/env python3
"""Prints where one particle of a trajectory is: particle.py TRAJECTORY.h5 NUMBER [STEP ...]

NUMBER counts from 1, as the reports do; without steps every sample is printed. Columns: step, time,
position, velocity, and the height of the highest of the other moving particles.
Needs h5py (Debian: python3-h5py).
"""
import sys

import h5py


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    path, number, wanted = sys.argv[1], int(sys.argv[2]) - 1, {int(s) for s in sys.argv[3:]}
    with h5py.File(path) as file:
        particles = file["particles/all"]
        position, velocity = particles["position"], particles["velocity"]
        moving = [i for i, held in enumerate(particles["pinned"][:]) if not held and i != number]
        print(f"{'step':>6} {'time':>9} {'x':>10} {'y':>10} {'vx':>10} {'vy':>10} {'others':>10}")
        for frame, (step, time) in enumerate(zip(position["step"][:], position["time"][:])):
            if wanted and step not in wanted:
                continue
            x, v = position["value"][frame], velocity["value"][frame]
            highest = max((x[i, 1] for i in moving), default=0.0)
            print(
                f"{step:6d} {time:9.6g} {x[number, 0]:10.6f} {x[number, 1]:10.6f} "
                f"{v[number, 0]:10.4f} {v[number, 1]:10.4f} {highest:10.4f}"
            )


if __name__ == "__main__":
    main()
