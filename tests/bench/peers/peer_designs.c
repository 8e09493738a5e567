// Random designs for the peers (peers.py): writes the problem, the designs and sobox's results, and
// prints how long sobox and a plain transcription in C took for them.
//
//     peer_designs PAIRS POINTS DESIGNS FOLDER
//
// FOLDER receives problem.json, designs.bin (design by design: each spring's x forces, then its y
// forces) and results.bin (design by design), both of native doubles.
#include "tests/physics/naive.h"
#include "worker/kinematics/kinematics.h"

#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { POINT_MAX = 32, BLOCK = 64, ROUNDS = 20, NAIVE_DESIGNS = 200 };

// The processor time of this thread [s]: what others do on the machine does not count.
static double clock_now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

struct peer {
    double deformation[POINT_MAX];
    struct kinematics_spring springs[KINEMATICS_SPRING_MAX];
    struct kinematics_setup setup;
    uint32_t points;
    uint32_t value_count;
    uint32_t result_count;
};

static void peer_init(struct peer *peer, uint32_t pairs, uint32_t points)
{
    for (uint32_t i = 0; i < points; i++) {
        peer->deformation[i] = 1.2 * i / (points - 1);
    }
    for (uint32_t i = 0; i < pairs; i++) {
        const double inwards = pairs > 1 ? (double)i / (pairs - 1) : 0.0;
        peer->springs[i] = (struct kinematics_spring){
            .position = {-0.83, -0.85 + 0.35 * inwards},
            .length = 1.25,
            .load = {peer->deformation, points},
        };
    }
    peer->points = points;
    peer->setup = (struct kinematics_setup){
        .mass = 1650.0,
        .yaw_inertia = 3000.0,
        .speed = 17.889,
        .face_x = -2.08,
        .edge_y = -0.455,
        .width = 1.15,
        .springs = peer->springs,
        .spring_count = pairs,
        .duration = 0.150,
        .time_step = 1e-3,
    };
}

static bool write_numbers(const char *folder, const char *name, const double *numbers, size_t count)
{
    g_autofree char *path = g_build_filename(folder, name, NULL);
    return g_file_set_contents(path, (const char *)numbers, (gssize)(count * sizeof *numbers),
                               NULL);
}

static bool write_problem(const struct peer *peer, const char *folder)
{
    const struct kinematics_setup *setup = &peer->setup;
    GString *text = g_string_new(NULL);
    g_string_append_printf(
        text,
        "{\"mass\": %.17g, \"inertia\": %.17g, \"speed\": %.17g, \"face_x\": %.17g, \"edge_y\": "
        "%.17g, \"width\": %.17g, \"duration\": %.17g, \"time_step\": %.17g, \"points\": %u, "
        "\"results\": %u,\n\"deformation\": [",
        setup->mass, setup->yaw_inertia, setup->speed, setup->face_x, setup->edge_y, setup->width,
        setup->duration, setup->time_step, peer->points, peer->result_count);
    for (uint32_t i = 0; i < peer->points; i++) {
        g_string_append_printf(text, "%s%.17g", i > 0 ? ", " : "", peer->deformation[i]);
    }
    g_string_append(text, "],\n\"springs\": [");
    for (uint32_t i = 0; i < setup->spring_count; i++) {
        g_string_append_printf(text, "%s[%.17g, %.17g, %.17g]", i > 0 ? ", " : "",
                               peer->springs[i].position[0], peer->springs[i].position[1],
                               peer->springs[i].length);
    }
    g_string_append(text, "]}\n");
    g_autofree char *path = g_build_filename(folder, "problem.json", NULL);
    const bool written = g_file_set_contents(path, text->str, -1, NULL);
    g_string_free(text, TRUE);
    return written;
}

// Where the kernel keeps result k of the peers, who know no lateral work and no balance.
static uint32_t peer_row(uint32_t k)
{
    return k <= KINEMATICS_KINETIC_ENERGY ? k : k - KINEMATICS_KINETIC_ENERGY - 1 + KINEMATICS_WORK;
}

// Evaluates all designs, stored design by design, in blocks; returns seconds a design, the best of
// some rounds.
static double time_sobox(const struct peer *peer, const double *designs, uint32_t count,
                         double *results)
{
    struct kinematics_problem *problem = kinematics_create(&peer->setup);
    g_autofree double *values = g_new0(double, (size_t)peer->value_count *BLOCK);
    g_autofree double *rows = g_new(double, (size_t)kinematics_result_count(problem) * BLOCK);
    double best = G_MAXDOUBLE;
    for (uint32_t first = 0; first < count; first += BLOCK) {
        const uint32_t block = MIN(count - first, (uint32_t)BLOCK);
        for (uint32_t i = 0; i < block; i++) {
            for (uint32_t k = 0; k < peer->value_count; k++) {
                values[k * BLOCK + i] = designs[(size_t)(first + i) * peer->value_count + k];
            }
        }
        for (int round = 0; round < ROUNDS; round++) {
            const double start = clock_now();
            kinematics_evaluate(problem, block, values, rows, BLOCK);
            best = block == BLOCK ? MIN(best, (clock_now() - start) / block) : best;
        }
        for (uint32_t i = 0; i < block; i++) {
            for (uint32_t k = 0; k < peer->result_count; k++) {
                results[(size_t)(first + i) * peer->result_count + k] =
                    rows[peer_row(k) * BLOCK + i];
            }
        }
    }
    kinematics_free(problem);
    return best;
}

static double time_naive(const struct peer *peer, const double *designs, uint32_t count)
{
    double results[KINEMATICS_RESULT_MAX];
    const double start = clock_now();
    for (uint32_t i = 0; i < count; i++) {
        naive_evaluate(&peer->setup, designs + (size_t)i * peer->value_count, results);
    }
    return (clock_now() - start) / count;
}

int main(int argc, char **argv)
{
    const uint32_t pairs = argc == 5 ? (uint32_t)strtoul(argv[1], NULL, 10) : 0;
    const uint32_t points = argc == 5 ? (uint32_t)strtoul(argv[2], NULL, 10) : 0;
    const uint32_t count = argc == 5 ? (uint32_t)strtoul(argv[3], NULL, 10) : 0;
    if (pairs < 1 || pairs > KINEMATICS_SPRING_MAX || points < 2 || points > POINT_MAX ||
        count < BLOCK) {
        fprintf(stderr, "expected: peer_designs PAIRS POINTS DESIGNS FOLDER, at least %d designs\n",
                BLOCK);
        return 2;
    }
    static struct peer peer;
    peer_init(&peer, pairs, points);
    peer.value_count = 2 * pairs * points;
    peer.result_count = KINEMATICS_KINETIC_ENERGY + 1 + pairs;
    g_autofree double *designs = g_new(double, (size_t)count *peer.value_count);
    g_autofree double *results = g_new(double, (size_t)count *peer.result_count);
    uint64_t state = 1;
    for (size_t i = 0; i < (size_t)count * peer.value_count; i++) {
        state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        designs[i] = 450e3 / pairs * ((double)(state >> 11) * 0x1p-53);
    }
    const double sobox = time_sobox(&peer, designs, count, results);
    const double naive = time_naive(&peer, designs, MIN(count, (uint32_t)NAIVE_DESIGNS));
    printf("%ux%u,sobox,%.3f,1\n", pairs, points, 1e6 * sobox);
    printf("%ux%u,plain C,%.3f,%.1f\n", pairs, points, 1e6 * naive, naive / sobox);
    const bool written =
        write_problem(&peer, argv[4]) &&
        write_numbers(argv[4], "designs.bin", designs, (size_t)count * peer.value_count) &&
        write_numbers(argv[4], "results.bin", results, (size_t)count * peer.result_count);
    if (!written) {
        fprintf(stderr, "%s: writing failed\n", argv[4]);
    }
    return written ? 0 : 1;
}
