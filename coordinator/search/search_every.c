// Design notes. The cutting sets know what they attacked, and no more: a box that is the widest
// under all limits found so far lies where the next attack has not been. So before a box is
// certified it stands still and is attacked by many fresh scouts; what breaks it becomes a limit,
// and the box is mended: it is moved a few steps with a greater tolerance. Then it is attacked
// again. The certificates' samples are one more attack: a bad one among them is a limit too.
#include "coordinator/search/search_every.h"

#include "coordinator/search/search_state.h"

#include "common/sampling/sampling.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

enum {
    EVERY_ATTACK_STEPS = 24, // on a box before it is certified
    EVERY_MEND_STEPS = 12,
    EVERY_RELAX_STEPS = 10,  // with one amount by which limits may be missed, then
    EVERY_SHARE_TIMES = 10,  // times `samples` designs of each kind
    EVERY_MENDS = 12,        // at most
    EVERY_TAKEN = 3,         // bad samples of a certificate that become attacks
    EVERY_STEPS_A_START = 8, // at least
};

// The bad share that is wanted of a box to be certified, as a part of what may be bad.
static const double every_share_wanted = 0.5;

static const double every_relaxation = 0.01; // of a constraint's scale, as in gain.h

// ---- asking

static struct cutting_set *set_of(struct search *search)
{
    return robust_current(&search->every.robust);
}

bool search_every_active(const struct search *search)
{
    return search->every.stage != EVERY_NONE;
}

static void ask_attack(struct search *search)
{
    struct cutting_set *set = set_of(search);
    const struct moves *moves = adversary_moves(&set->adversary);
    box_assign(&search->requested, cutting_set_box(set));
    const uint32_t per_attack = moves_count(&search->scenario->curves, &search->requested);
    search_ask_requested(search, moves->attacks * per_attack, SAMPLING_METHOD_MOVES,
                         VERDICT_DETAIL_MARGIN);
    search->request.sampling.moves = moves;
}

void search_every_ask(struct search *search)
{
    if (search->every.stage == EVERY_SHARE) {
        search_ask(search, &search->every.box, EVERY_SHARE_TIMES * search->scenario->search.samples,
                   protocol_kind_method(search->kind), VERDICT_DETAIL_SHARE);
        return;
    }
    if (search->every.stage != EVERY_CERTIFY) {
        ask_attack(search);
        return;
    }
    search_ask(search, &search->every.box, search->scenario->search.certificate_samples,
               protocol_kind_method(search->kind), VERDICT_DETAIL_MARGIN);
}

// ---- from stage to stage

static void enter(struct search *search, enum search_every_stage stage, enum search_phase phase)
{
    search->every.stage = stage;
    search->every.stage_steps = 0;
    search->phase = phase;
}

// Without a start there is the whole space alone.
static void begin(struct search *search, const struct cloud *starts, uint32_t steps)
{
    struct search_every *every = &search->every;
    box_init(&every->box, search->frame.space.count);
    box_init(&every->worst, search->frame.all.count);
    robust_init(&every->robust, &search->frame, &search->demands, &search->scenario->curves,
                search->scenario->constraint_count, search->scenario->search.samples, search->seed,
                starts, steps);
    cutting_set_centre(set_of(search), &every->box);
}

// Samples of an adversarial step.
static uint64_t step_cost(const struct search *search)
{
    struct box whole;
    box_init(&whole, search->frame.all.count);
    frame_widen(&search->frame, &search->frame.space, &whole);
    const uint32_t per_attack = moves_count(&search->scenario->curves, &whole);
    box_fini(&whole);
    return (uint64_t)adversary_attacks(search->scenario->search.samples, per_attack) * per_attack;
}

// Steps that a budget leaves beside one attack of the final box and its certificates.
static uint64_t affordable(const struct search *search)
{
    const struct scenario_search *settings = &search->scenario->search;
    const uint64_t cost = step_cost(search);
    const uint64_t reserve =
        DESIGN_KIND_COUNT * (uint64_t)settings->certificate_samples + EVERY_ATTACK_STEPS * cost;
    const uint64_t spent = search->evaluations + reserve;
    if (settings->evaluations == 0)
        return UINT64_MAX;
    return spent < settings->evaluations ? (settings->evaluations - spent) / cost : 0;
}

void search_every_start(struct search *search, const struct cloud *starts, uint32_t steps)
{
    const uint64_t most_steps = affordable(search);
    steps = most_steps < steps ? (uint32_t)most_steps : steps;
    struct cloud few = *starts;
    const uint32_t most = steps / EVERY_STEPS_A_START > 1 ? steps / EVERY_STEPS_A_START : 1;
    few.count = few.count < most ? few.count : most;
    begin(search, &few, steps);
    enter(search, EVERY_GROW, SEARCH_PHASE_EXPLORE);
}

void search_every_look(struct search *search, const struct box *box, enum search_status status)
{
    struct search_every *every = &search->every;
    box_init(&every->box, search->frame.space.count);
    box_init(&every->worst, search->frame.all.count);
    box_assign(&every->box, box);
    robust_init_one(&every->robust, &search->frame, &search->demands, &search->scenario->curves,
                    search->scenario->constraint_count, search->scenario->search.samples,
                    search->seed, box);
    every->margin = INFINITY;
    every->status = status;
    cutting_set_stand(set_of(search));
    enter(search, EVERY_LOOK, SEARCH_PHASE_CERTIFY);
}

// What the limits of the last box say of its bounds, in all variables.
static void find_holders(struct search *search)
{
    struct search_every *every = &search->every;
    const uint32_t free_sides = 2 * search->frame.space.count;
    g_autofree uint8_t *holders = g_new(uint8_t, free_sides + 1);
    every->gains = g_new0(double, search->scenario->constraint_count);
    every->holders = g_malloc(2 * (size_t)search->frame.all.count);
    memset(every->holders, CUTTING_SET_NOTHING, 2 * (size_t)search->frame.all.count);
    cutting_set_holders(set_of(search), holders, every->gains);
    for (uint32_t side = 0; side < free_sides; side++)
        every->holders[2 * search->frame.variables[side / 2] + side % 2] = holders[side];
    for (uint32_t c = 0; c < search->scenario->constraint_count; c++)
        every->gains[c] *= every_relaxation;
}

static void end(struct search *search, enum search_status status)
{
    find_holders(search);
    search->every.stage = EVERY_NONE;
    search->kind = DESIGN_KIND_POINTS;
    search_finish_box(search, status);
}

static void round_box(struct search *search)
{
    const double step = search->scenario->search.round;
    if (!(step > 0) || scenario_is_box(search->scenario))
        return;
    struct box *box = &search->every.box;
    cutting_set_centre(set_of(search), box);
    demands_round(&search->demands, step, box);
    cutting_set_place(set_of(search), box);
}

static void attack(struct search *search)
{
    search->every.margin = INFINITY;
    cutting_set_stand(set_of(search));
    round_box(search);
    enter(search, EVERY_ATTACK, SEARCH_PHASE_CERTIFY);
}

// ---- the promise of curves: the box of good designs, of which a little is given away (relax.h)

static void relax(struct search *search)
{
    cutting_set_relax(set_of(search), search->every.relax.amount);
    enter(search, EVERY_RELAX, SEARCH_PHASE_CONSOLIDATE);
}

static void look_at_shares(struct search *search)
{
    search->every.bad_share = 0;
    search->kind = DESIGN_KIND_POINTS;
    enter(search, EVERY_SHARE, SEARCH_PHASE_CONSOLIDATE);
}

// What one kind showed of the box; after the last one the next amount is tried.
static void complete_share(struct search *search)
{
    struct search_every *every = &search->every;
    const uint32_t samples = search->request.sampling.samples;
    every->bad_share =
        fmax(every->bad_share, (double)(samples - search->good_count) / (double)samples);
    search->kind = search_next_kind(search);
    if ((uint32_t)search->kind < DESIGN_KIND_COUNT)
        return;
    search->kind = DESIGN_KIND_POINTS;
    const double most = every_share_wanted * (1 - search->scenario->search.target_purity);
    const bool kept = every->bad_share <= most;
    if (kept)
        cutting_set_keep(set_of(search));
    if (relax_next(&every->relax, kept)) {
        relax(search);
        return;
    }
    cutting_set_take_back(set_of(search));
    attack(search);
}

void search_every_take(struct search *search)
{
    begin(search, &(struct cloud){0}, 0);
    attack(search);
}

// A bad design was found in the box.
static void mend(struct search *search)
{
    if (search->every.mends++ == EVERY_MENDS || affordable(search) < EVERY_MEND_STEPS) {
        end(search, SEARCH_STATUS_PURITY_MISSED);
        return;
    }
    search->kind = DESIGN_KIND_POINTS;
    cutting_set_mend(set_of(search));
    enter(search, EVERY_MEND, SEARCH_PHASE_CONSOLIDATE);
}

// Whether a bad design has to leave the box.
static bool mends_bad(const struct search *search)
{
    return search->scenario->search.promise == PROMISE_EVERY && !scenario_is_box(search->scenario);
}

// Each round of looks begins with points: when theirs are used up, so is what may err.
static void certify(struct search *search)
{
    if (search->certificate.looks == CERTIFICATE_LOOKS)
        end(search, SEARCH_STATUS_PURITY_MISSED);
    else
        enter(search, EVERY_CERTIFY, SEARCH_PHASE_CERTIFY);
}

// ---- what came of a step

// The design of a sample, as a box without width.
static void note_worst(struct search *search, uint32_t sample, double margin)
{
    struct search_every *every = &search->every;
    if (!(margin < every->margin))
        return;
    every->margin = margin;
    sampling_pick(&search->request.sampling, &search->requested, &sample, 1, every->worst.lower, 1);
    memcpy(every->worst.upper, every->worst.lower, every->worst.count * sizeof *every->worst.upper);
}

static void complete_attack(struct search *search, const struct verdict *verdicts)
{
    struct search_every *every = &search->every;
    struct adversary_report *report = &every->robust.report;
    every->stage_steps++;
    every->attacks += search->request.sampling.samples;
    if (every->stage == EVERY_GROW) {
        const bool spent = robust_complete(&every->robust, &search->request.sampling, verdicts);
        search->phase = every->robust.round < 2 ? SEARCH_PHASE_EXPLORE : SEARCH_PHASE_CONSOLIDATE;
        if (spent && search->scenario->search.promise == PROMISE_CURVES) {
            cutting_set_keep(set_of(search));
            relax_init(&every->relax);
            relax(search);
        } else if (spent) {
            attack(search);
        }
        return;
    }
    cutting_set_complete(set_of(search), &search->request.sampling, verdicts, report);
    if (every->stage == EVERY_ATTACK || every->stage == EVERY_LOOK)
        note_worst(search, report->worst, report->margin);
    if (every->stage == EVERY_LOOK && every->stage_steps == EVERY_ATTACK_STEPS) {
        every->stage = EVERY_NONE;
        search_begin_explain(search, every->status);
        return;
    }
    if (every->stage == EVERY_MEND && every->stage_steps == EVERY_MEND_STEPS)
        attack(search);
    else if (every->stage == EVERY_RELAX && every->stage_steps == EVERY_RELAX_STEPS)
        look_at_shares(search);
    else if (every->stage == EVERY_ATTACK && report->bad > 0 && mends_bad(search))
        mend(search);
    else if (every->stage == EVERY_ATTACK && every->stage_steps == EVERY_ATTACK_STEPS)
        certify(search);
}

// Makes an attack of a sample of a certificate.
static void attack_by(struct search *search, uint32_t sample, const struct verdict *verdict)
{
    g_autofree double *values = g_new(double, search->frame.all.count);
    g_autofree uint8_t *levels = g_new(uint8_t, search->frame.space.count + 1);
    sampling_pick(&search->request.sampling, &search->requested, &sample, 1, values, 1);
    for (uint32_t f = 0; f < search->frame.space.count; f++) {
        const uint32_t v = search->frame.variables[f];
        const double lower = search->requested.lower[v], upper = search->requested.upper[v];
        levels[f] = (uint8_t)lround((values[v] - lower) / (upper - lower) * MOVES_LEVEL_MAX);
    }
    adversary_add(&set_of(search)->adversary, levels, verdict->constraint, (double)verdict->margin);
}

static void complete_kind(struct search *search, const struct verdict *verdicts)
{
    const uint32_t samples = search->request.sampling.samples;
    const uint32_t bad = samples - search->good_count;
    struct certificate *certificate =
        search->kind == DESIGN_KIND_POINTS ? &search->certificate : &search->kinds[search->kind];
    certificate_look(certificate, samples, bad);
    uint32_t taken = 0;
    for (uint32_t i = 0; i < samples; i++) {
        note_worst(search, i, (double)verdicts[i].margin);
        if (verdicts[i].violation != VERDICT_GOOD && taken++ < EVERY_TAKEN)
            attack_by(search, i, &verdicts[i]);
    }
    if (bad > 0 && mends_bad(search)) {
        mend(search);
        return;
    }
    search->kind = search_next_kind(search);
    if ((uint32_t)search->kind < DESIGN_KIND_COUNT)
        return;
    bool certified = search->every.margin >= 0 || search->scenario->search.promise != PROMISE_EVERY;
    for (int kind = DESIGN_KIND_POINTS; kind < DESIGN_KIND_COUNT; kind++) {
        const struct certificate *of_kind =
            kind == DESIGN_KIND_POINTS ? &search->certificate : &search->kinds[kind];
        certified = certified && (of_kind->looks == 0 ||
                                  of_kind->lower95 >= search->scenario->search.target_purity);
    }
    if (!certified && search->scenario->search.promise == PROMISE_CURVES &&
        !scenario_is_box(search->scenario) && search->certificate.looks < CERTIFICATE_LOOKS) {
        relax_back(&search->every.relax);
        search->kind = DESIGN_KIND_POINTS;
        cutting_set_relax(set_of(search), search->every.relax.amount);
        enter(search, EVERY_MEND, SEARCH_PHASE_CONSOLIDATE);
        return;
    }
    end(search, certified ? SEARCH_STATUS_DONE : SEARCH_STATUS_PURITY_MISSED);
}

void search_every_complete(struct search *search, const struct verdict *verdicts)
{
    assert(search_every_active(search));
    if (search->every.stage == EVERY_CERTIFY)
        complete_kind(search, verdicts);
    else if (search->every.stage == EVERY_SHARE)
        complete_share(search);
    else
        complete_attack(search, verdicts);
    if (search->scenario->search.promise != PROMISE_POINTS)
        cutting_set_centre(set_of(search), &search->every.box);
}

void search_every_fini(struct search_every *every)
{
    robust_fini(&every->robust);
    box_fini(&every->box);
    box_fini(&every->worst);
    g_free(every->holders);
    g_free(every->gains);
    *every = (struct search_every){0};
}
