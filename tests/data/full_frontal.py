#!/usr/bin/env python3
"""Makes full_frontal_forces.csv and full_frontal_motion.csv from a folder of NHTSA test 10146.

    tests/data/full_frontal.py FOLDER tests/data

FOLDER holds the EV5 file and the channel files as NHTSA gives them out. The script selects channels by
what the EV5 file says of them, and by their unit: among the cells' channels one is a moment that the
file labels with the axis of a force.

Forces: the offset before contact is taken off, the sign is turned so that a force on the barrier is
positive, and each value is the mean over the millisecond around its time, which keeps the impulse. A
cell that the EV5 file calls failed stands in the table with 0.
Motion: the offset before contact is taken off, the acceleration is integrated twice from the impact
speed of the EV5 file, and the results are written every millisecond in the scenario's axes (forwards
is -x).
"""
import re
import sys
from pathlib import Path

GRAVITY = 9.80665  # m/s2
CELL = 0.125  # m, the side of a cell
MILLISECONDS = 150  # the last time of the tables
QUIET_UNTIL = -0.005  # s, the offset is the mean before
SEATS = ("FLLR", "FLRR")  # rear seat crossmember, left and right: nothing crushes there
UNITS = {"AC": "G'S", "LC": "NWT"}


class Channel:
    """One record of the section INSTRUMENTATION, and the file that belongs to it."""

    def __init__(self, stem, record):
        field = record.split("|")
        self.vehicle, self.number, self.sensor = field[0], int(field[1]), field[2]
        self.attachment, self.axis, self.unit = field[4], field[5], field[7]
        self.speed = float(field[13]) / 3.6
        self.first, self.last, self.step = int(field[14]), int(field[15]), 1e-6 * float(field[16])
        self.status = field[17]
        self.path = stem.with_suffix(f".{self.number:03d}")

    def wanted(self):
        return UNITS.get(self.sensor) == self.unit and self.axis in ("XG", "XL")

    def failed(self):
        return self.status != "AM"

    def values(self):
        """The samples without their offset, from t = 0 less half a millisecond on."""
        rows = [line.split() for line in self.path.read_text("latin-1").splitlines() if line.strip()]
        if len(rows) != self.last - self.first + 1:
            sys.exit(f"{self.path}: expected {self.last - self.first + 1} samples, found {len(rows)}")
        time = [float(row[0]) for row in rows]
        value = [float(row[1]) for row in rows]
        quiet = [v for t, v in zip(time, value) if t < QUIET_UNTIL]
        offset = sum(quiet) / len(quiet)
        per_ms = round(1e-3 / self.step)
        if per_ms % 2 or abs(time[-self.first]) > 0.5 * self.step:
            sys.exit(f"{self.path}: expected an even number of steps a millisecond and t = 0 at "
                     f"index {-self.first}")
        if self.last < MILLISECONDS * per_ms + per_ms // 2:
            sys.exit(f"{self.path}: ends before {MILLISECONDS} ms")
        return [v - offset for v in value[-self.first - per_ms // 2:]], per_ms


def read_channels(folder):
    (path,) = [p for p in folder.iterdir() if p.suffix.lower() == ".ev5"]
    section, channels = None, []
    for line in path.read_text("latin-1").splitlines():
        heading = re.fullmatch(r"----- (\w+) -----", line.strip())
        if heading:
            section = heading[1]
        elif section == "INSTRUMENTATION" and line and not line.startswith("#"):
            channels.append(Channel(path, line))
    return [channel for channel in channels if channel.wanted()]


def mean_forces(channel):
    """The force on the cell every millisecond: the trapezoid mean over the millisecond around it."""
    value, per_ms = channel.values()
    forces = []
    for i in range(0, MILLISECONDS * per_ms + 1, per_ms):
        piece = value[i:i + per_ms + 1]
        forces.append(-(sum(piece) - 0.5 * (piece[0] + piece[-1])) / per_ms)
    return forces


def motion(channel):
    """Velocity and travel every millisecond, forwards positive."""
    value, per_ms = channel.values()
    value = value[per_ms // 2:]
    velocity, travel, path = channel.speed, 0.0, []
    for i in range(MILLISECONDS * per_ms + 1):
        if i > 0:
            slower = velocity + 0.5 * GRAVITY * (value[i - 1] + value[i]) * channel.step
            travel += 0.5 * (velocity + slower) * channel.step
            velocity = slower
        if i % per_ms == 0:
            path.append((velocity, travel))
    return path


def write_forces(channels, path):
    cells = []
    for channel in channels:
        place = re.fullmatch(r"LC(\d\d)(\d\d)", channel.attachment)
        if channel.vehicle == "0" and channel.sensor == "LC" and place:
            if channel.failed():
                print(f"cell {channel.attachment} failed: taken for 0", file=sys.stderr)
            forces = [0.0] * (MILLISECONDS + 1) if channel.failed() else mean_forces(channel)
            cells.append((int(place[1]), int(place[2]), forces))
    cells.sort()
    rows, columns = max(c[0] for c in cells), max(c[1] for c in cells)
    if len(cells) != rows * columns:
        sys.exit(f"expected {rows} x {columns} cells, found {len(cells)}")
    with path.open("w", newline="\n") as file:
        file.write("time_s," + ",".join(f"row{c[0]}col{c[1]}" for c in cells) + "\n")
        for ms in range(MILLISECONDS + 1):
            forces = (str(10 * round(0.1 * cell[2][ms])) for cell in cells)
            file.write(f"{1e-3 * ms:.3f}," + ",".join(forces) + "\n")


def write_motion(channels, path):
    working = [c for c in channels if c.vehicle == "1" and not c.failed()]
    seats = [c for c in working if c.attachment in SEATS]
    engine = [c for c in working if c.attachment == "ENGN"]
    paths = [motion(c) for c in seats + engine]
    with path.open("w", newline="\n") as file:
        names = [f"x_{c.number}_m" for c in seats] + [f"vx_{c.number}_mps" for c in seats + engine]
        file.write("time_s,x_m,y_m,yaw_rad," + ",".join(names) + "\n")
        for ms in range(MILLISECONDS + 1):
            now = [p[ms] for p in paths]
            travel = [-at[1] for at in now[:len(seats)]]
            row = [sum(travel) / len(seats), 0.0, 0.0] + travel + [-at[0] for at in now]
            file.write(f"{1e-3 * ms:.3f}," + ",".join(f"{v + 0.0:.4f}" for v in row) + "\n")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    channels = read_channels(Path(sys.argv[1]))
    write_forces(channels, Path(sys.argv[2]) / "full_frontal_forces.csv")
    write_motion(channels, Path(sys.argv[2]) / "full_frontal_motion.csv")


main()
