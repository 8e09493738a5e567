#!/usr/bin/python3
"""What cluster_rates measures of sobox, over Dask distributed with numba in its place: a cluster of
two worker processes of one thread each, on TCP over loopback, and the same models written as a
numba user would. Prints the same rows of CSV, with dask+numba as the program.

    dask_bench.py SCENARIO_FOLDER

The crash model is written from the equations of the thesis's chapter 6, one design after the other;
numba compiles it for this machine and may reorder floating point as it likes.
"""

import os
import statistics
import sys
import time

try:
    import numba
    import numpy as np
    import yaml
    from distributed import Client, LocalCluster
except ImportError as missing:
    sys.exit(f"dask_bench: {missing}: install python3-distributed python3-numba python3-yaml; "
             "run with the distribution's /usr/bin/python3")

WORKERS = 2
ROUNDS = 5
S_L_MIN, AB_WP = 0, 1


@numba.njit(fastmath=True, nogil=True)
def crash(values, setup, places, lengths, deformation, outcomes):
    """values: (designs, springs, 2, points) [N]; outcomes: (designs, 2) s_L_min, AbWP."""
    mass, inertia, speed, face_x, edge_y, width, overlap, duration, dt = setup
    steps = int(round(duration / dt))
    springs, points = deformation.shape
    before = np.empty(springs)
    for d in range(values.shape[0]):
        x0 = y0 = w0 = 0.0
        x1, y1, w1 = -speed * dt, 0.0, 0.0
        least_length, last_y2 = lengths[0], 0.0
        start_y2 = places[0, 1]
        for k in range(springs):
            before[k] = lengths[k] - (places[k, 0] - face_x)
        for step in range(1, steps + 1):
            c, s = np.cos(w1), np.sin(w1)
            force_x = force_y = moment = 0.0
            for k in range(springs):
                px = x1 + c * places[k, 0] - s * places[k, 1]
                py = y1 + s * places[k, 0] + c * places[k, 1]
                y2 = py + s / c * (face_x - px)
                length = (px - face_x) / c
                crush = lengths[k] - length
                touches = edge_y - width <= y2 <= edge_y and crush > 0 and c > 0
                if k == 0:
                    last_y2 = y2
                    if touches:
                        least_length = min(least_length, length)
                fx = fy = 0.0
                if touches and crush > before[k] and crush >= deformation[k, 0]:
                    i = points - 1
                    if crush >= deformation[k, i]:
                        fx, fy = values[d, k, 0, i], values[d, k, 1, i]
                    else:
                        i = 0
                        while crush >= deformation[k, i + 1]:
                            i += 1
                        t = (crush - deformation[k, i]) / (deformation[k, i + 1] - deformation[k, i])
                        fx = values[d, k, 0, i] + t * (values[d, k, 0, i + 1] - values[d, k, 0, i])
                        fy = values[d, k, 1, i] + t * (values[d, k, 1, i + 1] - values[d, k, 1, i])
                before[k] = crush
                gx, gy = c * fx - s * fy, s * fx + c * fy
                force_x += gx
                force_y += gy
                moment += gx * (y1 - y2) - gy * (x1 - face_x)
            if step == steps:
                break
            x0, x1 = x1, force_x / mass * dt * dt + 2 * x1 - x0
            y0, y1 = y1, force_y / mass * dt * dt + 2 * y1 - y0
            w0, w1 = w1, moment / inertia * dt * dt + 2 * w1 - w0
        outcomes[d, S_L_MIN] = least_length
        outcomes[d, AB_WP] = (last_y2 - start_y2) / overlap


class Crash:
    """A scenario of the crash model, as plain arrays that travel well."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            scenario = yaml.safe_load(file)
        number = lambda value: float(value)  # YAML 1.1 takes 450e3 for a word
        vehicle, barrier, springs = scenario["vehicle"], scenario["barrier"], scenario["springs"]
        reach = number(barrier["edge_y"]) - number(springs[0]["position"][1])
        self.setup = (number(vehicle["mass"]), number(vehicle["yaw_inertia"]),
                      number(vehicle["speed"]), number(barrier["face_x"]),
                      number(barrier["edge_y"]), number(barrier.get("width", 1.15)),
                      number(barrier.get("overlap", reach)), 0.150, 1e-3)
        self.places = np.array([[number(x) for x in spring["position"]] for spring in springs])
        self.lengths = np.array([number(spring.get("length", place[0] - self.setup[3]))
                                 for spring, place in zip(springs, self.places)])
        self.deformation = np.array([[number(x) for x in s["deformation"]] for s in springs])
        points = self.deformation.shape[1]
        self.bounds = np.empty((2, len(springs), 2, points))
        for k, spring in enumerate(springs):
            for direction, name in enumerate(("force_x", "force_y")):
                for side, bound in enumerate(("lower", "upper")):
                    value = spring[name][bound]
                    self.bounds[side, k, direction] = (
                        [number(x) for x in value] if isinstance(value, list) else number(value))
        self.firewall = number(scenario["firewall_distance"])


def sample_crash(problem, seed, count):
    """A batch: random designs, their outcomes, good or bad and how badly."""
    setup, places, lengths, deformation, bounds, firewall = problem
    random = np.random.default_rng(seed)
    values = bounds[0] + (bounds[1] - bounds[0]) * random.random((count, *bounds.shape[1:]))
    outcomes = np.empty((count, 2))
    crash(values, setup, places, lengths, deformation, outcomes)
    return np.maximum(firewall - outcomes[:, S_L_MIN], 0).astype(np.float32)


@numba.njit(fastmath=True, nogil=True)
def sphere(values, violation):
    limit = np.sqrt(values.shape[1]) / 2
    for d in range(values.shape[0]):
        square = 0.0
        for v in range(values.shape[1]):
            square += values[d, v] * values[d, v]
        violation[d] = max(np.sqrt(square) - limit, 0.0)


def sample_sphere(variables, share, seed, count):
    random = np.random.default_rng(seed)
    values = share * (2 * random.random((count, variables)) - 1)
    violation = np.empty(count, np.float32)
    sphere(values, violation)
    return violation


def cpu_of_worker():
    return time.process_time()


def show(figure, values, unit, greater_is_better=False):
    best = max(values) if greater_is_better else min(values)
    print(f"{figure},dask+numba,{best:.4g},{statistics.median(values):.4g},{unit},,"
          f"{os.getloadavg()[0]:.1f}", flush=True)


def measure_step(client, problem):
    times = []
    for step in range(120):
        start = time.perf_counter()
        parts = client.map(sample_crash, [problem] * WORKERS,
                           [2 * step, 2 * step + 1], [100] * WORKERS, pure=False)
        client.gather(parts)
        times.append(1e6 * (time.perf_counter() - start))
    show("step_of_200", times[20:], "us")


def measure_batches(client):
    rates, good = [], []
    for turn in range(ROUNDS):
        start = time.perf_counter()
        parts = client.map(sample_sphere, [10] * 400, [0.8] * 400,
                           range(400 * turn, 400 * turn + 400), [200] * 400, pure=False)
        outcomes = client.gather(parts)
        rates.append(400 / (time.perf_counter() - start))
        good.append(float(np.mean([np.mean(part == 0) for part in outcomes])))
    show("batches_of_200", rates, "1/s", True)
    show("batch_of_200_good", good, "1")


def kernel_us(crash_problem, problem):
    """One core's processor time a design: the model alone, and from random numbers on."""
    count = 20000
    bounds = crash_problem.bounds
    values = bounds[0] + (bounds[1] - bounds[0]) * np.random.default_rng(1).random(
        (count, *bounds.shape[1:]))
    outcomes = np.empty((count, 2))
    start = time.thread_time()
    crash(values, *problem[:4], outcomes)
    middle = time.thread_time()
    sample_crash(problem, 1, count)
    return [1e6 * (middle - start) / count, 1e6 * (time.thread_time() - middle) / count]


def measure_bulk(client, crash_problem, problem):
    """Steps of 20,000, in four parts a worker: as few as let one that is late be made up for."""
    parts = 4 * WORKERS
    count = 20000 // parts
    wall, efficiency, efficiency_cpu, share, good, kernel, whole = ([] for _ in range(7))
    for turn in range(ROUNDS):
        model_us, whole_us = kernel_us(crash_problem, problem)
        workers = sum(client.run(cpu_of_worker).values())
        own, start = time.process_time(), time.perf_counter()
        for step in range(4):
            first = parts * (4 * turn + step)
            outcomes = client.gather(client.map(
                sample_crash, [problem] * parts, range(first, first + parts), [count] * parts,
                pure=False))
        sample_us = 1e6 * (time.perf_counter() - start) / 80000
        own = time.process_time() - own
        workers = sum(client.run(cpu_of_worker).values()) - workers
        kernel.append(model_us)
        whole.append(whole_us)
        wall.append(sample_us)
        efficiency.append(100 * model_us / (WORKERS * sample_us))
        efficiency_cpu.append(100 * model_us / (1e6 * workers / 80000))
        share.append(100 * own / workers)
        good.append(float(np.mean([np.mean(part == 0) for part in outcomes])))
    show("bulk_sample", wall, "us")
    show("bulk_kernel", kernel, "us")
    show("bulk_kernel_to_verdict", whole, "us")
    show("bulk_efficiency", efficiency, "%", True)
    show("bulk_efficiency_cpu", efficiency_cpu, "%", True)
    show("bulk_cpu_coordinator", share, "% of workers")
    show("bulk_good", good, "1")


def main():
    folder = sys.argv[1]
    two = Crash(os.path.join(folder, "sedan-two-springs.yaml"))
    ten = Crash(os.path.join(folder, "sedan-ten-springs.yaml"))
    plain = lambda c: (c.setup, c.places, c.lengths, c.deformation, c.bounds, c.firewall)
    with LocalCluster(n_workers=WORKERS, threads_per_worker=1, processes=True, host="127.0.0.1",
                      dashboard_address=None) as cluster, Client(cluster) as client:
        # Compiling is not what is measured: here and on both workers beforehand.
        for compiled in (sample_crash(plain(two), 0, 1), sample_sphere(10, 0.8, 0, 1)):
            assert len(compiled) == 1
        client.run(sample_crash, plain(two), 0, 1)
        client.run(sample_sphere, 10, 0.8, 0, 1)
        measure_step(client, plain(two))
        measure_batches(client)
        measure_bulk(client, ten, plain(ten))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: dask_bench.py SCENARIO_FOLDER")
    main()
