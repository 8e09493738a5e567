// Design notes. The barrier's weight falls from 1 to 3e-5 by tenths, with a few Newton steps each.
// The Hessian is H + A' D A: H has a block of 2 x 2 for each variable (log-width and ranges) and
// one entry for the excess, A has a row a limit, D = barrier / slack^2. With B = A H^-1 A' + D^-1,
// Newton's step is
//
//     step = H^-1 (A' B^-1 A H^-1 g - g)
//
// All sums run in the order of the indexes, in one thread: the same bits everywhere.
#include "coordinator/search/widest.h"

#include <glib.h>
#include <math.h>
#include <string.h>

enum { WIDEST_NEWTON_MAX = 8 }; // steps at one weight of the barrier

static const double widest_barrier_first = 1;
static const double widest_barrier_last = 3e-5; // leaves (limits + sides) x 3e-5 of log-volume
static const double widest_barrier_fall = 0.1;
static const double widest_settled = 0.1;  // of Newton's decrement: near enough for the next weight
static const double widest_inside = 0.05;  // of its range: how far a side starts from its ends
static const double widest_towards = 0.95; // of the way to the next barrier, at most

struct newton {
    const struct widest_problem *problem;
    uint32_t sides;
    double barrier;
    double *at;       // (sides + 1) where the method stands: sides, then the excess
    double *gradient; // (sides + 1)
    double *step;     // (sides + 1)
    double *inverse;  // (3 x variables) of the blocks: lower-lower, lower-upper, upper-upper
    double excess_inverse;
    double *slack;  // (limits)
    double *rows;   // (limits x (sides + 1)) A H^-1
    double *matrix; // (limits x limits) B, then its Cholesky factor
    double *right;  // (limits)
};

static bool stands_still(const struct widest_problem *problem, uint32_t side)
{
    return !(problem->most[side] > problem->least[side]);
}

static double dot(const double *a, const double *b, uint32_t count)
{
    // Eight sums at a time, always the same eight: vectors of any width give the same bits.
    double sum[8] = {0};
    uint32_t i = 0;
    for (; i + 8 <= count; i += 8) {
        for (uint32_t k = 0; k < 8; k++)
            sum[k] += a[i + k] * b[i + k];
    }
    for (; i < count; i++)
        sum[i % 8] += a[i] * b[i];
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

static void measure_slacks(struct newton *newton, const double *at, double *slack)
{
    const struct widest_problem *problem = newton->problem;
    for (uint32_t i = 0; i < problem->limit_count; i++)
        slack[i] = dot(problem->limit[i], at, newton->sides) + problem->constant[i] -
                   problem->tolerance + at[newton->sides];
}

// The barrier function; infinite outside.
static double value_of(struct newton *newton, const double *at, double *slack)
{
    const struct widest_problem *problem = newton->problem;
    double value = 0, logs = 0;
    for (uint32_t v = 0; v < problem->variables; v++) {
        const double width = at[2 * v + 1] - at[2 * v];
        if (!(width > 0))
            return INFINITY;
        value -= (problem->weights == NULL ? 1 : problem->weights[v]) * log(width);
    }
    for (uint32_t side = 0; side < newton->sides; side++) {
        if (stands_still(problem, side))
            continue;
        const double below = at[side] - problem->least[side];
        const double above = problem->most[side] - at[side];
        if (!(below > 0) || !(above > 0))
            return INFINITY;
        logs += log(below * above);
    }
    measure_slacks(newton, at, slack);
    for (uint32_t i = 0; i < problem->limit_count; i++) {
        if (!(slack[i] > 0))
            return INFINITY;
        logs += log(slack[i]);
    }
    const double excess = at[newton->sides];
    if (!(excess > 0))
        return INFINITY;
    return value + problem->price * excess - newton->barrier * (logs + log(excess));
}

// The derivatives but for those of the limits, and the inverse of the blocks.
static void differentiate_box(struct newton *newton)
{
    const struct widest_problem *problem = newton->problem;
    const double barrier = newton->barrier, *at = newton->at;
    for (uint32_t v = 0; v < problem->variables; v++) {
        const double weight = problem->weights == NULL ? 1 : problem->weights[v];
        const double width = at[2 * v + 1] - at[2 * v];
        double diagonal[2], gradient[2] = {weight / width, -weight / width};
        const double cross = -weight / (width * width);
        bool still[2];
        for (uint32_t k = 0; k < 2; k++) {
            const uint32_t side = 2 * v + k;
            still[k] = stands_still(problem, side);
            if (still[k])
                continue;
            const double below = at[side] - problem->least[side];
            const double above = problem->most[side] - at[side];
            gradient[k] += barrier * (1 / above - 1 / below);
            diagonal[k] = -cross + barrier * (1 / (below * below) + 1 / (above * above));
        }
        double *inverse = newton->inverse + 3 * (size_t)v;
        inverse[0] = inverse[1] = inverse[2] = 0;
        if (!still[0] && !still[1]) {
            const double determinant = diagonal[0] * diagonal[1] - cross * cross;
            inverse[0] = diagonal[1] / determinant;
            inverse[1] = -cross / determinant;
            inverse[2] = diagonal[0] / determinant;
        } else if (!still[0]) {
            inverse[0] = 1 / diagonal[0];
        } else if (!still[1]) {
            inverse[2] = 1 / diagonal[1];
        }
        newton->gradient[2 * v] = gradient[0];
        newton->gradient[2 * v + 1] = gradient[1];
    }
    const double excess = at[newton->sides];
    newton->gradient[newton->sides] = problem->price - barrier / excess;
    newton->excess_inverse = excess * excess / barrier;
}

static void add_limit_gradients(struct newton *newton)
{
    const struct widest_problem *problem = newton->problem;
    for (uint32_t i = 0; i < problem->limit_count; i++) {
        const double pull = newton->barrier / newton->slack[i];
        for (uint32_t side = 0; side < newton->sides; side++)
            newton->gradient[side] -= pull * problem->limit[i][side];
        newton->gradient[newton->sides] -= pull;
    }
}

// H^-1 times a vector of all sides and the excess.
static void apply_inverse(const struct newton *newton, const double *vector, double *result)
{
    for (uint32_t v = 0; v < newton->problem->variables; v++) {
        const double *inverse = newton->inverse + 3 * (size_t)v;
        const double lower = vector[2 * v], upper = vector[2 * v + 1];
        result[2 * v] = inverse[0] * lower + inverse[1] * upper;
        result[2 * v + 1] = inverse[1] * lower + inverse[2] * upper;
    }
    result[newton->sides] = newton->excess_inverse * vector[newton->sides];
}

// B and its Cholesky factor, in the lower triangle.
static void factorize(struct newton *newton)
{
    const uint32_t count = newton->problem->limit_count, row = newton->sides + 1;
    for (uint32_t i = 0; i < count; i++) {
        double *of_row = newton->rows + (size_t)i * row;
        for (uint32_t v = 0; v < newton->problem->variables; v++) {
            const double *inverse = newton->inverse + 3 * (size_t)v;
            const double *limit = newton->problem->limit[i];
            of_row[2 * v] = inverse[0] * limit[2 * v] + inverse[1] * limit[2 * v + 1];
            of_row[2 * v + 1] = inverse[1] * limit[2 * v] + inverse[2] * limit[2 * v + 1];
        }
        of_row[newton->sides] = newton->excess_inverse;
        for (uint32_t j = 0; j <= i; j++)
            newton->matrix[(size_t)i * count + j] =
                dot(of_row, newton->problem->limit[j], newton->sides) + newton->excess_inverse;
        newton->matrix[(size_t)i * count + i] +=
            newton->slack[i] * newton->slack[i] / newton->barrier;
    }
    for (uint32_t i = 0; i < count; i++) {
        double *row_i = newton->matrix + (size_t)i * count;
        for (uint32_t j = 0; j <= i; j++) {
            const double *row_j = newton->matrix + (size_t)j * count;
            const double rest = row_i[j] - dot(row_i, row_j, j);
            if (j < i)
                row_i[j] = rest / row_j[j];
            else // equal limits make it singular but for rounding
                row_i[i] = sqrt(rest > 1e-14 * row_i[i] ? rest : 1e-14 * row_i[i]);
        }
    }
}

static void solve_factorized(const struct newton *newton, double *right)
{
    const uint32_t count = newton->problem->limit_count;
    for (uint32_t i = 0; i < count; i++) {
        const double *row = newton->matrix + (size_t)i * count;
        right[i] = (right[i] - dot(row, right, i)) / row[i];
    }
    for (uint32_t i = count; i-- > 0;) {
        right[i] /= newton->matrix[(size_t)i * count + i];
        for (uint32_t j = 0; j < i; j++)
            right[j] -= newton->matrix[(size_t)i * count + j] * right[i];
    }
}

// Newton's step; returns the square of its decrement.
static double find_step(struct newton *newton)
{
    const uint32_t count = newton->problem->limit_count, row = newton->sides + 1;
    differentiate_box(newton);
    add_limit_gradients(newton);
    factorize(newton);
    apply_inverse(newton, newton->gradient, newton->step); // H^-1 g
    for (uint32_t i = 0; i < count; i++)
        newton->right[i] = dot(newton->problem->limit[i], newton->step, newton->sides) +
                           newton->step[newton->sides];
    solve_factorized(newton, newton->right);
    for (uint32_t side = 0; side < row; side++)
        newton->step[side] = -newton->step[side];
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t side = 0; side < row; side++)
            newton->step[side] += newton->right[i] * newton->rows[(size_t)i * row + side];
    }
    return -dot(newton->gradient, newton->step, row);
}

// The part of the step that reaches a barrier.
static double reach_of(const struct newton *newton)
{
    const struct widest_problem *problem = newton->problem;
    double reach = 1 / widest_towards;
    for (uint32_t side = 0; side < newton->sides; side++) {
        const double step = newton->step[side];
        double room = INFINITY;
        if (step < 0)
            room = (newton->at[side] - problem->least[side]) / -step;
        else if (step > 0)
            room = (problem->most[side] - newton->at[side]) / step;
        reach = room < reach ? room : reach;
    }
    for (uint32_t i = 0; i < problem->limit_count; i++) {
        const double fall =
            -dot(problem->limit[i], newton->step, newton->sides) - newton->step[newton->sides];
        if (fall > 0 && newton->slack[i] / fall < reach)
            reach = newton->slack[i] / fall;
    }
    return widest_towards * reach;
}

// Goes along the step as far as the barrier function falls; false where it does not.
static bool go(struct newton *newton, double *trial, double *slack)
{
    const double before = value_of(newton, newton->at, newton->slack);
    for (double part = reach_of(newton); part > 1e-8; part /= 2) {
        for (uint32_t side = 0; side <= newton->sides; side++)
            trial[side] = newton->at[side] + part * newton->step[side];
        if (value_of(newton, trial, slack) < before) {
            memcpy(newton->at, trial, (newton->sides + 1) * sizeof *trial);
            memcpy(newton->slack, slack, newton->problem->limit_count * sizeof *slack);
            return true;
        }
    }
    return false;
}

// Inside all ranges, with an excess that makes up for every limit that is missed.
static void start(struct newton *newton, const double *sides)
{
    const struct widest_problem *problem = newton->problem;
    for (uint32_t side = 0; side < newton->sides; side++) {
        const double least = problem->least[side], most = problem->most[side];
        const double margin = widest_inside * (most - least);
        double at = sides[side];
        at = at < least + margin ? least + margin : at;
        newton->at[side] = at > most - margin ? most - margin : at;
    }
    newton->at[newton->sides] = 0;
    measure_slacks(newton, newton->at, newton->slack);
    double missed = 0;
    for (uint32_t i = 0; i < problem->limit_count; i++)
        missed = -newton->slack[i] > missed ? -newton->slack[i] : missed;
    newton->at[newton->sides] = missed + 0.01;
}

void widest(const struct widest_problem *problem, struct widest_answer *answer)
{
    const uint32_t sides = 2 * problem->variables, limits = problem->limit_count;
    // One piece of memory for all of it.
    const size_t doubles = 4 * ((size_t)sides + 1) + 3 * (size_t)problem->variables +
                           4 * (size_t)limits + (size_t)limits * (sides + 1) +
                           (size_t)limits * limits;
    g_autofree double *memory = g_new0(double, doubles);
    double *next = memory;
    struct newton newton = {.problem = problem, .sides = sides};
    newton.at = next, next += sides + 1;
    newton.gradient = next, next += sides + 1;
    newton.step = next, next += sides + 1;
    double *trial = next;
    next += sides + 1;
    newton.inverse = next, next += 3 * (size_t)problem->variables;
    newton.slack = next, next += limits;
    newton.right = next, next += limits;
    double *slack = next;
    next += limits;
    newton.rows = next, next += (size_t)limits * (sides + 1);
    newton.matrix = next;

    start(&newton, answer->sides);
    newton.barrier = widest_barrier_first;
    for (;;) {
        for (uint32_t i = 0; i < WIDEST_NEWTON_MAX; i++) {
            measure_slacks(&newton, newton.at, newton.slack);
            const double decrement = find_step(&newton);
            if (decrement < widest_settled * newton.barrier || !go(&newton, trial, slack))
                break;
        }
        if (newton.barrier <= widest_barrier_last)
            break;
        newton.barrier *= widest_barrier_fall;
        if (newton.barrier < widest_barrier_last)
            newton.barrier = widest_barrier_last;
    }
    memcpy(answer->sides, newton.at, sides * sizeof *answer->sides);
    answer->excess = newton.at[sides];
    measure_slacks(&newton, newton.at, newton.slack);
    answer->shadow = 0;
    for (uint32_t i = 0; i < limits; i++) {
        const double price = newton.barrier / newton.slack[i];
        answer->shadow += price;
        if (answer->prices != NULL)
            answer->prices[i] = price;
    }
}
