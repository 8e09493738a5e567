// Design notes. Flips are taken together, as if their effects added: from any design that is two or
// three steps to a corner where no flip makes it worse. Where effects do not add, the one worst
// neighbour, measured and not expected, makes sure that something is gained. Variables that change
// nothing in an attack (the force at a deformation which it never reaches) get the lower level:
// otherwise attacks that are the same crash would fill the table.
#include "coordinator/search/adversary.h"

#include "common/numeric/random.h"
#include "common/sampling/sampling.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    ADVERSARY_TIMES = 6,  // as many samples of a step as other steps have, about
    ADVERSARY_MOST = 256, // attacks, at most and
    ADVERSARY_LEAST = 10, // at least
    ADVERSARY_OWN = 3,    // attacks that each constraint keeps, however mild
};

// Counters of random numbers for scouts, apart from those of moves and samples.
static const uint32_t adversary_counter = UINT32_C(0xC0000000);

static const double adversary_gain = 1e-6;       // by which a neighbour has to be worse
static const double adversary_idle = 1e-9;       // below which a variable changes nothing
static const double adversary_margin_most = 1e3; // so that sums stay finite

uint32_t adversary_attacks(uint32_t samples, uint32_t per_attack)
{
    const uint64_t wanted = ADVERSARY_TIMES * (uint64_t)samples / per_attack;
    return wanted < ADVERSARY_LEAST  ? ADVERSARY_LEAST
           : wanted > ADVERSARY_MOST ? ADVERSARY_MOST
                                     : (uint32_t)wanted;
}

void adversary_init(struct adversary *adversary, const struct frame *frame,
                    const struct curve_map *curves, uint32_t constraints, uint32_t samples,
                    uint64_t seed)
{
    struct box whole;
    box_init(&whole, frame->all.count);
    frame_widen(frame, &frame->space, &whole);
    const uint32_t per_attack = moves_count(curves, &whole);
    box_fini(&whole);
    const uint32_t most = adversary_attacks(samples, per_attack);
    *adversary = (struct adversary){
        .frame = frame,
        .curves = curves,
        .constraints = constraints,
        .seed = seed,
        .most = most,
        .scouts = most / ADVERSARY_SCOUT_SHARE,
        .room = 3 * most + 64,
        .moves = {.variables = frame->all.count},
    };
    adversary->attacks = g_new0(struct attack, adversary->room);
    for (uint32_t i = 0; i < adversary->room; i++)
        adversary->attacks[i].levels = g_new0(uint8_t, frame->space.count + 1);
    adversary->moves.rows = g_new0(uint8_t, (size_t)adversary->room * (1 + frame->all.count));
}

void adversary_fini(struct adversary *adversary)
{
    for (uint32_t i = 0; i < adversary->room; i++)
        g_free(adversary->attacks[i].levels);
    g_free(adversary->attacks);
    moves_fini(&adversary->moves);
    *adversary = (struct adversary){0};
}

// FNV-1a: short, and the same everywhere.
static uint64_t name_of(const uint8_t *levels, uint32_t count, uint8_t target)
{
    uint64_t name = UINT64_C(14695981039346656037);
    for (uint32_t i = 0; i < count; i++)
        name = (name ^ levels[i]) * UINT64_C(1099511628211);
    return (name ^ target) * UINT64_C(1099511628211);
}

static struct attack *add(struct adversary *adversary, const uint8_t *levels, uint8_t target,
                          double margin, bool scout)
{
    const uint32_t variables = adversary->frame->space.count;
    const uint64_t name = name_of(levels, variables, target);
    for (uint32_t i = 0; i < adversary->count; i++) {
        if (adversary->attacks[i].name == name)
            return NULL;
    }
    if (adversary->count == adversary->room)
        return NULL;
    struct attack *attack = &adversary->attacks[adversary->count++];
    memcpy(attack->levels, levels, variables);
    attack->name = name;
    attack->margin = margin;
    attack->target = target;
    attack->scout = scout;
    attack->resting = false;
    return attack;
}

void adversary_add(struct adversary *adversary, const uint8_t *levels, uint8_t target,
                   double margin)
{
    add(adversary, levels, target, margin, false);
}

// ---- where attacks come from

// The levels of scout `number`: by turns whole curves at bounds, whole groups at bounds, single
// variables at bounds.
static void scout_levels(const struct adversary *adversary, uint32_t number, uint8_t *levels)
{
    const uint32_t key[2] = {(uint32_t)adversary->seed, (uint32_t)(adversary->seed >> 32)};
    const struct frame *frame = adversary->frame;
    for (uint32_t f = 0; f < frame->space.count; f++) {
        const uint32_t v = frame->variables[f];
        const uint32_t slot = number % 3 == 0   ? adversary->curves->curve[v]
                              : number % 3 == 1 ? adversary->curves->group[v]
                                                : v;
        const uint32_t counter[4] = {adversary_counter | slot / 128, number, 0, 0};
        uint32_t block[4];
        random_philox(counter, key, block);
        levels[f] = block[slot / 32 % 4] >> slot % 32 & 1 ? MOVES_LEVEL_MAX : 0;
    }
}

static void start_scout(struct adversary *adversary)
{
    g_autofree uint8_t *levels = g_new(uint8_t, adversary->frame->space.count + 1);
    // A scout that starts where an attack stands learns nothing: another try or two.
    for (uint32_t i = 0; i < 3; i++) {
        const uint32_t number = adversary->started++;
        scout_levels(adversary, number, levels);
        if (add(adversary, levels, (uint8_t)(number / 3 % adversary->constraints), INFINITY, true))
            return;
    }
}

// All groups at their bounds in every way, as far as they are few.
static void add_groups(struct adversary *adversary)
{
    const struct frame *frame = adversary->frame;
    const uint32_t groups =
        adversary->curves->group_count <= 3 ? adversary->curves->group_count : 0;
    g_autofree uint8_t *levels = g_new(uint8_t, frame->space.count + 1);
    for (uint32_t way = 0; way < 1u << groups; way++) {
        for (uint32_t f = 0; f < frame->space.count; f++) {
            const uint32_t group = groups > 0 ? adversary->curves->group[frame->variables[f]] : 0;
            levels[f] = way >> group & 1 ? MOVES_LEVEL_MAX : 0;
        }
        for (uint32_t c = 0; c < adversary->constraints; c++)
            add(adversary, levels, (uint8_t)c, INFINITY, false);
    }
}

void adversary_begin(struct adversary *adversary)
{
    add_groups(adversary);
    for (uint32_t i = 0; i < adversary->scouts; i++)
        start_scout(adversary);
    adversary->count = adversary->count < adversary->most ? adversary->count : adversary->most;
}

const struct moves *adversary_moves(struct adversary *adversary)
{
    const struct frame *frame = adversary->frame;
    struct moves *moves = &adversary->moves;
    moves->attacks = adversary->count;
    memset(moves->rows, 0, moves_size(moves));
    for (uint32_t i = 0; i < adversary->count; i++) {
        uint8_t *row = moves->rows + (size_t)i * (1 + moves->variables);
        row[0] = adversary->attacks[i].target;
        for (uint32_t f = 0; f < frame->space.count; f++)
            row[1 + frame->variables[f]] = adversary->attacks[i].levels[f];
    }
    return moves;
}

// ---- what came of a step

static double margin_of(const struct verdict *verdict)
{
    const double margin = (double)verdict->margin;
    if (!(margin > -adversary_margin_most)) // a non-finite outcome among them
        return -adversary_margin_most;
    return margin < adversary_margin_most ? margin : adversary_margin_most;
}

// The samples of one attack.
struct sampled {
    const struct verdict *verdicts; // (per attack) the attack, flips, probes, curves, leaps
    const struct sampling *sampling;
    const struct box *box;
    uint32_t first; // sample of the step
    uint32_t per_attack;
};

static double flip_of(const struct sampled *sampled, uint32_t f)
{
    return margin_of(&sampled->verdicts[1 + f]);
}

static double probe_of(const struct sampled *sampled, uint32_t variables, uint32_t f)
{
    return margin_of(&sampled->verdicts[1 + variables + f]);
}

static double slope_of(uint8_t level, double margin, double probe)
{
    const double slope = (probe - margin) / MOVES_PROBE;
    return level < MOVES_LEVEL_MAX / 2 ? slope : -slope;
}

static void settle_idle(struct attack *attack, const struct sampled *sampled, uint32_t variables)
{
    for (uint32_t f = 0; f < variables; f++) {
        if (fabs(flip_of(sampled, f) - attack->margin) < adversary_idle &&
            fabs(probe_of(sampled, variables, f) - attack->margin) < adversary_idle)
            attack->levels[f] = 0;
    }
    attack->name = name_of(attack->levels, variables, attack->target);
}

static bool at_corner(const struct attack *attack, uint32_t variables)
{
    for (uint32_t f = 0; f < variables; f++) {
        if (attack->levels[f] != 0 && attack->levels[f] != MOVES_LEVEL_MAX)
            return false;
    }
    return true;
}

// All flips that make it worse, at once. Returns how many there are.
static uint32_t flip_all(const struct attack *attack, const struct sampled *sampled,
                         uint32_t variables, uint8_t *levels, double *expected)
{
    uint32_t count = 0;
    *expected = attack->margin;
    memcpy(levels, attack->levels, variables);
    for (uint32_t f = 0; f < variables; f++) {
        const double change = flip_of(sampled, f) - attack->margin;
        if (change > -adversary_gain)
            continue;
        levels[f] = levels[f] < MOVES_LEVEL_MAX / 2 ? MOVES_LEVEL_MAX : 0;
        *expected += change;
        count++;
    }
    return count;
}

// The worst neighbour that was sampled; 0, the attack itself, where none is worse.
static uint32_t worst_neighbour(const struct attack *attack, const struct sampled *sampled)
{
    uint32_t worst = 0;
    double least = attack->margin - adversary_gain;
    for (uint32_t i = 1; i < sampled->per_attack; i++) {
        const double margin = margin_of(&sampled->verdicts[i]);
        if (margin < least) {
            least = margin;
            worst = i;
        }
    }
    return worst;
}

// The levels of a sample in the free variables.
static void levels_of(const struct adversary *adversary, const struct sampled *sampled,
                      uint32_t move, uint8_t *levels)
{
    const struct frame *frame = adversary->frame;
    g_autofree uint8_t *all = g_new(uint8_t, frame->all.count);
    moves_levels(sampled->sampling, sampled->box, sampled->first + move, all);
    for (uint32_t f = 0; f < frame->space.count; f++)
        levels[f] = all[frame->variables[f]];
}

// Makes attacks of what is worse than attack `at`.
static void climb(struct adversary *adversary, uint32_t at, const struct sampled *sampled)
{
    const uint32_t variables = adversary->frame->space.count;
    struct attack *attack = &adversary->attacks[at];
    const bool scout = attack->scout;
    const uint32_t worst = worst_neighbour(attack, sampled);
    attack->resting = worst == 0;
    if (worst == 0) {
        attack->scout = false; // it stays for as long as it is dangerous
        return;
    }
    g_autofree uint8_t *levels = g_new(uint8_t, variables + 1);
    double expected;
    const uint8_t target = attack->target;
    bool added = false;
    if (flip_all(attack, sampled, variables, levels, &expected) > 1)
        added = add(adversary, levels, target, expected, scout) != NULL;
    levels_of(adversary, sampled, worst, levels);
    add(adversary, levels, target, margin_of(&sampled->verdicts[worst]), scout && !added);
    adversary->attacks[at].scout = false;
}

static int compare_attacks(const void *a, const void *b)
{
    const struct attack *one = a, *other = b;
    if (one->scout != other->scout)
        return one->scout ? -1 : 1;
    if (one->margin != other->margin)
        return one->margin < other->margin ? -1 : 1;
    return one->name < other->name ? -1 : one->name > other->name;
}

// Attacks that have become the same design stand side by side.
static void drop_equal(struct adversary *adversary)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < adversary->count; i++) {
        if (count > 0 && adversary->attacks[i].name == adversary->attacks[count - 1].name)
            continue;
        const struct attack kept = adversary->attacks[count];
        adversary->attacks[count++] = adversary->attacks[i];
        adversary->attacks[i] = kept; // whose room for levels is used again
    }
    adversary->count = count;
}

// Keeps the most dangerous: scouts first, then some of each constraint, then by margin.
static void select_attacks(struct adversary *adversary)
{
    qsort(adversary->attacks, adversary->count, sizeof *adversary->attacks, compare_attacks);
    drop_equal(adversary);
    const uint32_t own = adversary->most / (2 * adversary->constraints) < ADVERSARY_OWN
                             ? adversary->most / (2 * adversary->constraints)
                             : ADVERSARY_OWN;
    uint32_t of_target[256] = {0};
    for (uint32_t i = 0; i < adversary->count; i++) {
        struct attack *attack = &adversary->attacks[i];
        if (!attack->scout && of_target[attack->target]++ < own)
            attack->margin -= 2 * adversary_margin_most; // for the order only
    }
    qsort(adversary->attacks, adversary->count, sizeof *adversary->attacks, compare_attacks);
    for (uint32_t i = 0; i < adversary->count; i++) {
        if (adversary->attacks[i].margin < -1.5 * adversary_margin_most)
            adversary->attacks[i].margin += 2 * adversary_margin_most;
    }
    uint32_t scouts = 0;
    while (scouts < adversary->count && adversary->attacks[scouts].scout)
        scouts++;
    const uint32_t missing = scouts < adversary->scouts ? adversary->scouts - scouts : 0;
    const uint32_t kept = adversary->most - missing;
    adversary->count = adversary->count < kept ? adversary->count : kept;
    for (uint32_t i = 0; i < missing; i++)
        start_scout(adversary);
}

static void report_step(struct adversary_report *report, const struct verdict *verdicts,
                        uint32_t samples)
{
    *report = (struct adversary_report){.margin = INFINITY};
    for (uint32_t i = 0; i < samples; i++) {
        report->bad += verdicts[i].violation != VERDICT_GOOD;
        const double margin = margin_of(&verdicts[i]);
        if (margin < report->margin) {
            report->margin = margin;
            report->worst = i;
        }
    }
}

void adversary_complete(struct adversary *adversary, const struct sampling *sampling,
                        const struct box *box, const struct verdict *verdicts,
                        void (*view)(void *context, const struct attack_view *view), void *context,
                        struct adversary_report *report)
{
    const uint32_t variables = adversary->frame->space.count, sampled_count = adversary->count;
    const uint32_t per_attack = moves_count(adversary->curves, box);
    g_autofree double *slopes = g_new(double, variables + 1);
    report_step(report, verdicts, sampling->samples);
    for (uint32_t at = 0; at < sampled_count; at++) {
        struct attack *attack = &adversary->attacks[at];
        const struct sampled sampled = {.verdicts = verdicts + (size_t)at * per_attack,
                                        .sampling = sampling,
                                        .box = box,
                                        .first = at * per_attack,
                                        .per_attack = per_attack};
        attack->margin = margin_of(&sampled.verdicts[0]);
        for (uint32_t f = 0; f < variables; f++)
            slopes[f] =
                slope_of(attack->levels[f], attack->margin, probe_of(&sampled, variables, f));
        const uint64_t former = attack->name;
        settle_idle(attack, &sampled, variables);
        climb(adversary, at, &sampled);
        attack = &adversary->attacks[at];
        report->climbing += !attack->resting;
        view(context,
             &(struct attack_view){.attack = attack,
                                   .slopes = slopes,
                                   .former = former,
                                   .limits = attack->resting || at_corner(attack, variables)});
    }
    select_attacks(adversary);
}
