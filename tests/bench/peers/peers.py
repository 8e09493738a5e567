#!/usr/bin/python3
"""The same designs through numba and through plain Python in the thesis's style.

    peers.py FOLDER CASE SOBOX_US

FOLDER is what peer_designs wrote. Checks that both agree with sobox to 1e-9 of each result's size and
prints CSV rows: case, peer, microseconds a design, ratio to sobox's SOBOX_US.
Needs Debian's python3-numba and python3-numpy.
"""
import json
import math
import sys
import time

import numba
import numpy

PLAIN_DESIGNS = 20
TOLERANCE = 1e-9


@numba.njit(cache=False)
def crash(mass, inertia, speed, face_x, edge_y, width, dt, steps, deformation, springs, forces, out):
    """One design by equations 6.9 to 6.46, central difference. forces: (spring, direction, point)."""
    count = springs.shape[0]
    points = deformation.shape[0]
    before = numpy.zeros(count)
    before[:] = -1e300
    x = y = yaw = 0.0
    last_x = last_y = last_yaw = 0.0
    length_last = springs[0, 2]
    length_min = springs[0, 2]
    yaw_max = force_max = force_sum = 0.0
    contacts = 0
    vx = vy = vyaw = 0.0
    projection = springs[0, 1]
    for step in range(steps + 1):
        c = math.cos(yaw)
        s = math.sin(yaw)
        sum_x = sum_y = moment = 0.0
        touched = False
        for i in range(count):
            p1x = x + springs[i, 0] * c - springs[i, 1] * s
            p1y = y + springs[i, 0] * s + springs[i, 1] * c
            p2y = p1y + math.tan(yaw) * (face_x - p1x)
            length = (p1x - face_x) / c
            deformed = springs[i, 2] - length
            contact = edge_y - width <= p2y <= edge_y and deformed > 0.0 and c > 0.0
            loads = deformed > before[i]
            before[i] = deformed
            if i == 0:
                projection = p2y
            if not contact:
                continue
            touched = True
            if i == 0 and step > 0:
                length_last = length
                length_min = min(length_min, length)
            if not loads or deformed < deformation[0]:
                continue
            if deformed >= deformation[points - 1]:
                local_x = forces[i, 0, points - 1]
                local_y = forces[i, 1, points - 1]
            else:
                k = 0
                while deformed >= deformation[k + 1]:
                    k += 1
                share = (deformed - deformation[k]) / (deformation[k + 1] - deformation[k])
                local_x = forces[i, 0, k] + share * (forces[i, 0, k + 1] - forces[i, 0, k])
                local_y = forces[i, 1, k] + share * (forces[i, 1, k + 1] - forces[i, 1, k])
            fx = c * local_x - s * local_y
            fy = s * local_x + c * local_y
            sum_x += fx
            sum_y += fy
            moment += fx * (y - p2y) - fy * (x - face_x)
        if step > 0:
            yaw_max = max(yaw_max, abs(yaw))
            force_max = max(force_max, abs(sum_x))
            force_sum += sum_x
            contacts += touched
        ax = sum_x / mass
        ay = sum_y / mass
        ayaw = moment / inertia
        if step == steps:
            vx = (x - last_x) / dt + 0.5 * ax * dt
            vy = (y - last_y) / dt + 0.5 * ay * dt
            vyaw = (yaw - last_yaw) / dt + 0.5 * ayaw * dt
        elif step == 0:
            x = -speed * dt
        else:
            next_x = ax * dt * dt + 2.0 * x - last_x
            next_y = ay * dt * dt + 2.0 * y - last_y
            next_yaw = ayaw * dt * dt + 2.0 * yaw - last_yaw
            last_x, last_y, last_yaw = x, y, yaw
            x, y, yaw = next_x, next_y, next_yaw
    out[0] = length_last
    out[1] = length_min
    out[2] = y + springs[0, 0] * math.sin(yaw) + springs[0, 1] * math.cos(yaw) - springs[0, 1]
    out[3] = projection - springs[0, 1]
    out[4] = yaw
    out[5] = yaw_max
    out[6] = x
    out[7] = y
    out[8] = vx + speed
    out[9] = vy
    out[10] = force_max / mass
    out[11] = force_sum / mass / max(contacts, 1)
    out[12] = 0.5 * mass * (vx * vx + vy * vy) + 0.5 * inertia * vyaw * vyaw


@numba.njit(cache=False)
def crashes(mass, inertia, speed, face_x, edge_y, width, dt, steps, deformation, springs, forces, out):
    for i in range(forces.shape[0]):
        crash(mass, inertia, speed, face_x, edge_y, width, dt, steps, deformation, springs, forces[i],
              out[i])


class Spring:
    """A pair of springs as a thesis writes it: lists of points, numpy at every step."""

    def __init__(self, place, deformation, forces):
        self.place = numpy.array(place[:2])
        self.length = place[2]
        self.deformation = deformation
        self.force_x, self.force_y = forces
        self.before = -math.inf

    def force(self, q, problem):
        rotation = numpy.array([[math.cos(q[2]), -math.sin(q[2])], [math.sin(q[2]), math.cos(q[2])]])
        p1 = q[:2] + rotation @ self.place
        p2 = numpy.array([problem["face_x"], p1[1] + math.tan(q[2]) * (problem["face_x"] - p1[0])])
        length = (p1[0] - problem["face_x"]) / math.cos(q[2])
        deformed = self.length - length
        loads = deformed > self.before
        self.before = deformed
        inside = problem["edge_y"] - problem["width"] <= p2[1] <= problem["edge_y"]
        contact = inside and deformed > 0.0 and math.cos(q[2]) > 0.0
        local = numpy.zeros(2)
        if contact and loads:
            local = numpy.array([numpy.interp(deformed, self.deformation, self.force_x),
                                 numpy.interp(deformed, self.deformation, self.force_y)])
        force = rotation @ local
        moment = force[0] * (q[1] - p2[1]) - force[1] * (q[0] - p2[0])
        return numpy.array([force[0], force[1], moment]), length, contact


def thesis(problem, forces):
    """One design; s_L, travel of the COG and yaw."""
    springs = [Spring(place, problem["deformation"], curves)
               for place, curves in zip(problem["springs"], forces)]
    masses = numpy.array([problem["mass"], problem["mass"], problem["inertia"]])
    dt = problem["time_step"]
    places = [numpy.zeros(3), numpy.array([-problem["speed"] * dt, 0.0, 0.0])]
    length_last = springs[0].length
    for spring in springs:
        spring.force(places[0], problem)
    steps = round(problem["duration"] / dt)
    for step in range(1, steps + 1):
        loads = [spring.force(places[-1], problem) for spring in springs]
        if loads[0][2]:
            length_last = loads[0][1]
        if step < steps:
            total = sum(load[0] for load in loads)
            places.append(total / masses * dt**2 + 2.0 * places[-1] - places[-2])
    return [length_last, places[-1][2], places[-1][0], places[-1][1]]


def check(peer, theirs, ours):
    """Every result to 1e-9 of its size: that of the largest among all designs."""
    size = numpy.maximum(numpy.abs(ours).max(axis=0), 1e-6)
    worst = float((numpy.abs(theirs - ours) / size).max())
    if not worst < TOLERANCE:
        sys.exit(f"{peer}: differs by {worst:.3g} of the results' size")
    return worst


def main():
    folder, case, sobox_us = sys.argv[1], sys.argv[2], float(sys.argv[3])
    with open(f"{folder}/problem.json", encoding="ascii") as file:
        problem = json.load(file)
    pairs, points = len(problem["springs"]), problem["points"]
    designs = numpy.fromfile(f"{folder}/designs.bin").reshape(-1, pairs, 2, points)
    ours = numpy.fromfile(f"{folder}/results.bin").reshape(designs.shape[0], -1)
    arguments = (problem["mass"], problem["inertia"], problem["speed"], problem["face_x"],
                 problem["edge_y"], problem["width"], problem["time_step"],
                 round(problem["duration"] / problem["time_step"]),
                 numpy.array(problem["deformation"]), numpy.array(problem["springs"]))
    out = numpy.zeros((designs.shape[0], 13))
    crashes(*arguments, designs[:1], out[:1])  # compiles
    best = math.inf
    for _ in range(5):
        start = time.thread_time()
        crashes(*arguments, designs, out)
        best = min(best, (time.thread_time() - start) / designs.shape[0])
    check("numba", out, ours[:, :13])
    print(f"{case},numba,{1e6 * best:.3f},{1e6 * best / sobox_us:.1f}")

    some = designs[:PLAIN_DESIGNS]
    start = time.thread_time()
    found = numpy.array([thesis(problem, forces) for forces in some])
    plain = (time.thread_time() - start) / some.shape[0]
    check("Python", found, ours[:PLAIN_DESIGNS][:, [0, 4, 6, 7]])
    print(f"{case},Python,{1e6 * plain:.0f},{1e6 * plain / sobox_us:.0f}")


main()
