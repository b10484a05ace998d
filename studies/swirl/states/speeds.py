#!/usr/bin/env python3
"""Speeds at which a particle becomes liquid and gas, TR299's Table IV: speeds.py [MASS ...]

Runs the scenes of this folder (driftlab run, every step kept) with other speeds of P1: upwards from
half the printed one in steps of a hundredth of it until the criterion is met, then by bisection to
0.01. The criteria:

    gas      P1 is farther than D from P2 and from P3 at some step
    swap     liquid: |P1 P4| > |P2 P3| at some step, before which their ratio has never fallen: the
             four particles change bonds in one movement
    upward   liquid: the same inequality, before which P1 has never moved downwards

Needs h5py. DRIFTLAB is the program (default: driftlab).
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import h5py
import numpy

HERE = pathlib.Path(__file__).resolve().parent
DRIFTLAB = os.environ.get("DRIFTLAB", "driftlab")
MASSES = (10000, 8000, 6000, 4000, 2000)
VELOCITY = re.compile(r"velocity: \[0, ([0-9.]+)\]")


def distance(place, i, j):
    return numpy.hypot(*(place[:, i] - place[:, j]).T)


def gas(place, velocity, reach):
    far = (distance(place, 0, 1) > reach) & (distance(place, 0, 2) > reach)
    return far.any()


def before(event, spoilt):
    """Whether `event` happens at a step up to which `spoilt` has not."""
    return (event & ~numpy.logical_or.accumulate(spoilt)).any()


def swap(place, velocity, reach):
    ratio = distance(place, 0, 3) / distance(place, 1, 2)
    return before(ratio > 1, numpy.diff(ratio, prepend=0) < 0)


def upward(place, velocity, reach):
    return before(distance(place, 0, 3) > distance(place, 1, 2), velocity[:, 0, 1] < 0)


class Experiment:
    """One scene with any speed of P1."""

    def __init__(self, kind, mass, folder):
        self.text = (HERE / f"{kind}-{mass}.yaml").read_text()
        self.printed = float(VELOCITY.search(self.text).group(1))
        self.reach = float(re.search(r"until: ([0-9.]+)", self.text).group(1))
        self.folder = folder
        self.runs = {}

    def run(self, speed):
        if speed not in self.runs:
            scene, out = self.folder / "scene.yaml", self.folder / "run.h5"
            scene.write_text(VELOCITY.sub(f"velocity: [0, {speed!r}]", self.text, count=1))
            command = [DRIFTLAB, "run", scene, "--method", "leapfrog", "--sample", "1e-4"]
            subprocess.run([*command, "--out", out], check=True, stdout=subprocess.DEVNULL)
            with h5py.File(out) as file:
                group = file["particles/all"]
                self.runs[speed] = (group["position/value"][:], group["velocity/value"][:])
        return self.runs[speed]

    def meets(self, criterion, speed):
        return criterion(*self.run(speed), self.reach)

    def threshold(self, criterion):
        step = self.printed / 100
        low, high = 49 * step, 50 * step
        while not self.meets(criterion, high):
            low, high = high, high + step
            if high > 2 * self.printed:
                return float("nan")
        while high - low > 0.01:
            middle = (low + high) / 2
            low, high = (low, middle) if self.meets(criterion, middle) else (middle, high)
        return high


def main():
    print("  mass    v-gas  printed  /sqrt(m)    swap  upward  printed  swap/sqrt(m)")
    for mass in map(int, sys.argv[1:]) if len(sys.argv) > 1 else MASSES:
        with tempfile.TemporaryDirectory() as name:
            three = Experiment("gas", mass, pathlib.Path(name))
            four = Experiment("liquid", mass, pathlib.Path(name))
            free = three.threshold(gas)
            easy, straight = four.threshold(swap), four.threshold(upward)
            print(
                f"{mass:6}  {free:7.1f}  {three.printed:7.0f}  {free / mass**0.5:8.3f}"
                f"  {easy:6.1f}  {straight:6.1f}  {four.printed:7.0f}  {easy / mass**0.5:12.3f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
