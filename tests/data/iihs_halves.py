#!/usr/bin/env python3
"""Makes iihs_halves.csv: medians of groups of IIHS small overlap tests that were not told apart by
what they did, so that the curves of one group can be asked to predict another.

    iihs_halves.py MOTIONS.csv WEIGHTS.csv >iihs_halves.csv

MOTIONS.csv is slide_away/artifacts/tables/ri_vs_safety_map.csv of the public repository
yangduhi/IIHS_SOL: a row a test, with the velocity changes at 20, 40, ... 150 ms. WEIGHTS.csv has
filegroup_id and report_test_weight_kg_measured of slide_away/artifacts/marts/case_master.parquet
there, a table that any reader of Parquet can write out.

Taken are the driver-side tests of the consumer series (codes CEN...) whose car ends slower along its
travel by 5 to 20 m/s and moves away from the barrier by up to 15 m/s: 296 of 309. `odd` and `even` are every other
one in the order of the tests' numbers; `light` and `heavy` the thirds of least and greatest mass
among those with a mass.
"""
import csv
import statistics
import sys

TIMES = [0.0, 0.020, 0.040, 0.060, 0.080, 0.100, 0.120, 0.150]  # s
SPEED = 17.889  # m/s at first contact
COLUMNS = ("group,tests,time_s,delta_vx_mps,delta_vy_mps,travel_x_m,travel_y_m,"
           "spread_x_m,spread_y_m,mass_kg")


def integral(values):
    """Trapezoids over TIMES."""
    sums = [0.0]
    for i in range(1, len(TIMES)):
        sums.append(sums[-1] + (values[i] + values[i - 1]) / 2 * (TIMES[i] - TIMES[i - 1]))
    return sums


def read_tests(motions, weights):
    mass = {row["filegroup_id"]: row["report_test_weight_kg_measured"] for row in weights}
    tests = []
    for row in motions:
        along = [0.0] + [float(row[f"window_{1e3 * t:03.0f}_delta_vx_mps"]) for t in TIMES[1:]]
        aside = [0.0] + [float(row[f"window_{1e3 * t:03.0f}_delta_vy_away_mps"]) for t in TIMES[1:]]
        if (row["test_code"].startswith("CEN") and row["test_side"] == "driver"
                and -20 < along[-1] < -5 and 0 < aside[-1] < 15):
            tests.append({"number": int(row["filegroup_id"]), "vx": along, "vy": aside,
                          "x": integral([SPEED + v for v in along]), "y": integral(aside),
                          "mass": float(mass.get(row["filegroup_id"]) or "nan")})
    return sorted(tests, key=lambda test: test["number"])


def write_group(name, tests):
    masses = [test["mass"] for test in tests if test["mass"] == test["mass"]]

    def middle(quantity):
        return [statistics.median(test[quantity][i] for test in tests) for i in range(len(TIMES))]

    def spread(quantity, medians):
        return [statistics.fmean(abs(test[quantity][i] - medians[i]) for test in tests)
                for i in range(len(TIMES))]

    vx, vy = middle("vx"), middle("vy")
    x, y = integral([SPEED + v for v in vx]), integral(vy)
    spread_x, spread_y = spread("x", x), spread("y", y)
    for i, time in enumerate(TIMES):
        print(f"{name},{len(tests)},{time:.3f},{vx[i]:.3f},{vy[i]:.3f},{x[i]:.4f},{y[i]:.4f},"
              f"{spread_x[i]:.4f},{spread_y[i]:.4f},{statistics.median(masses):.0f}")


def main():
    with open(sys.argv[1], encoding="utf-8-sig", newline="") as motions, \
         open(sys.argv[2], encoding="utf-8-sig", newline="") as weights:
        tests = read_tests(csv.DictReader(motions), csv.DictReader(weights))
    print(COLUMNS)
    write_group("odd", tests[0::2])
    write_group("even", tests[1::2])
    weighed = sorted((t for t in tests if t["mass"] == t["mass"]), key=lambda test: test["mass"])
    third = len(weighed) // 3
    write_group("light", weighed[:third])
    write_group("heavy", weighed[-third:])


if __name__ == "__main__":
    main()
