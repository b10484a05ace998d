#!/usr/bin/env python3
"""Rotation of a swirl through a run: rotation.py RUN.h5 [STEPS]

A line every STEPS (default 10000) steps of 1e-4: the mean angular velocity (TR299 (3.12)) of all
particles and of the system, the rotation of the rigid body with the system's angular momentum, its
angle since the start in revolutions, the steps of a revolution at that rotation (- from a million
on), how many particles are not of the system, and how many are farther than 10 and 12 from its
centre. The system is the heaviest group of particles nearer than D = 2.3 to one another, as in
driftlab observe. Needs h5py.
"""
import sys

import h5py
import numpy

REACH, STEP = 2.3, 1e-4


def system(place, mass):
    """Mask of the heaviest group."""
    near = numpy.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1)) < REACH
    left, heaviest = numpy.ones(len(mass), bool), numpy.zeros(len(mass), bool)
    while left.any():
        group, edge = numpy.zeros_like(left), numpy.zeros_like(left)
        edge[numpy.argmax(left)] = True
        while edge.any():
            group |= edge
            edge = near[edge].any(axis=0) & ~group
        left &= ~group
        if mass[group].sum() > mass[heaviest].sum():
            heaviest = group
    return heaviest


def rotation(place, velocity, mass):
    """(3.12), and the rotation of the rigid body with the same angular momentum."""
    place = place - numpy.average(place, axis=0, weights=mass)
    velocity = velocity - numpy.average(velocity, axis=0, weights=mass)
    square = (place**2).sum(axis=1)
    moment = mass * (place[:, 0] * velocity[:, 1] - place[:, 1] * velocity[:, 0])
    return (moment / square).sum() / mass.sum(), moment.sum() / (mass * square).sum()


def main():
    every = int(sys.argv[2]) if len(sys.argv) > 2 else 10000
    print("  step  (3.12) all  system  rigid  revolutions  steps each  outside  R > 10  R > 12")
    with h5py.File(sys.argv[1]) as file:
        group, time = file["particles/all"], file["observables/energy_error/time"][:]
        mass, angle, last = group["mass"][:], 0.0, None
        stride = max(1, round(0.05 / (time[1] - time[0])))
        for frame in range(0, len(time), stride):
            place = group["position/value"][frame, :, :2]
            velocity = group["velocity/value"][frame, :, :2]
            inside = system(place, mass)
            mean, rigid = rotation(place[inside], velocity[inside], mass[inside])
            if last is not None:
                angle += (time[frame] - last[0]) * (rigid + last[1]) / 2
            last = time[frame], rigid
            step = round(time[frame] / STEP)
            if step % every == 0:
                everything = rotation(place, velocity, mass)[0]
                centre = numpy.average(place[inside], axis=0, weights=mass[inside])
                radius = numpy.hypot(*(place - centre).T)
                period = 2 * numpy.pi / abs(rigid) / STEP
                each = f"{period:.0f}" if period < 1e6 else "-"
                print(
                    f"{step:6}  {everything:10.3f}  {mean:6.3f}  {rigid:5.3f}"
                    f"  {angle / (2 * numpy.pi):11.3f}  {each:>10}"
                    f"  {(~inside).sum():7}  {(radius > 10).sum():6}  {(radius > 12).sum():6}"
                )


if __name__ == "__main__":
    main()
